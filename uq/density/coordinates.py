"""Coordinates η in which the sampler moves: equations and noise model in, η with its prior density out.

η joins the `Parametrisation` of the equations, every positive quantity in its logarithm, and the noise model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.noise.hyper import Hyper


@dataclass(frozen=True, slots=True, kw_only=True)
class Coordinates:
    """η = (coordinates of the free parameters, then the logarithms of the noise model's parameters).

    The prior of a parameter is its normal prior cut at the bounds, or flat between the bounds: in log x where ``scale``
    is ``log``, else in x. Positive quantities move in log x whatever their prior is flat in. Where amplitudes scatter,
    the data do not identify a common factor of inertia, stiffness and damping, and that ridge of the posterior is a
    straight line only in logarithms. The density is 0 where an ordering (Fs ≥ Fc) is violated.

    Parameters
    ----------
    parametrisation
        Free parameters of the equations, every positive one in its logarithm.
    hyper
        Parameters of the noise model, which follow those of the equations in η.
    widen
        Factor on the standard deviation of every normal prior and on the width of every noise parameter's prior [1].
    """

    parametrisation: Parametrisation
    hyper: tuple[Hyper, ...]
    widen: float = 1.0

    @classmethod
    def of(cls, equations: Equations, hyper: tuple[Hyper, ...], *, widen: float = 1.0) -> Coordinates:
        """Lay out the coordinates η of equations and noise model.

        Parameters
        ----------
        equations
            Equations whose free parameters are sampled.
        hyper
            Parameters of the noise model.
        widen
            Factor on the widths of the priors [1].

        Returns
        -------
        Coordinates
            The free parameters of the equations, every positive one in its logarithm, then those of the noise model.
        """
        parametrisation = Parametrisation.of(equations, every_positive_in_log=True)
        return cls(parametrisation=parametrisation, hyper=hyper, widen=widen)

    @property
    def equations(self) -> Equations:
        """Equations whose free parameters are sampled."""
        return self.parametrisation.equations

    @property
    def free(self) -> tuple[Quantity, ...]:
        """The parameters that are sampled."""
        return self.parametrisation.quantities

    @property
    def names(self) -> tuple[str, ...]:
        """Ids in the order of η."""
        return (*self.parametrisation.ids, *(h.id for h in self.hyper))

    @property
    def units(self) -> tuple[str, ...]:
        """Units in the order of η, each of the untransformed value."""
        return (*(q.unit for q in self.free), *(h.unit for h in self.hyper))

    @property
    def logarithmic(self) -> tuple[bool, ...]:
        """Whether each coordinate is a logarithm, in the order of η."""
        return (*self.parametrisation.log, *(True for _ in self.hyper))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.parametrisation.free) + len(self.hyper)

    def bounds(self) -> tuple[Array, Array]:
        """Return the bounds of η.

        Returns
        -------
        lower, upper : ndarray, shape (n,) each
            Those of a noise parameter are e⁻²⁵ and e²⁵: its prior, not they, is to limit it.
        """
        lower, upper = self.parametrisation.bounds
        # A model that lacks something leaves hundreds of times the noise: a mode on a bound would have no curvature.
        reach = 25.0 * np.ones(len(self.hyper))
        return np.concatenate([lower, -reach]), np.concatenate([upper, reach])

    def values(self, eta: Array) -> Array:
        """Return the untransformed values of η.

        Parameters
        ----------
        eta
            Coordinates, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            Parameters, clipped to their bounds, and noise parameters, in the units of `units`.
        """
        parameters, hyper = self._parts(eta)
        # exp overflows beyond 709: a trial far outside the bounds still has a finite value.
        return np.concatenate([self.parametrisation.values(parameters), np.exp(np.clip(hyper, -700, 700))], axis=-1)

    def inverse(self, values: Array) -> Array:
        """Return η of untransformed values, the inverse of `values`.

        Parameters
        ----------
        values
            Parameters and noise parameters, in the units of `units`, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            η: coordinates of the free parameters, then logarithms of the noise parameters.
        """
        parameters, hyper = self._parts(values)
        return np.concatenate([self.parametrisation.coordinates(parameters), np.log(hyper)], axis=-1)

    def thetas(self, eta: Array) -> Array:
        """Return the full parameter sets of the equations, fixed parameters at their initial values.

        Parameters
        ----------
        eta
            Coordinates, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n_p)
            θ in the order of ``equations.parameters``, within the bounds.
        """
        return self.parametrisation.physical(self._parts(eta)[0])

    def eta(self, theta: Array, hyper: Array | None = None) -> Array:
        """Return η of a full parameter set, which is clipped to its bounds first.

        Parameters
        ----------
        theta
            Parameters in the order of ``equations.parameters``, shape (n_p,).
        hyper
            Values of the noise model's parameters, in the order of ``self.hyper``; their starts where None.

        Returns
        -------
        ndarray, shape (n,)
            η: coordinates of the free parameters, then logarithms of the noise parameters.
        """
        start = np.array([h.start for h in self.hyper]) if hyper is None else hyper
        free = np.asarray(theta)[list(self.parametrisation.free)]
        inside = np.clip(free, self.parametrisation.lower, self.parametrisation.upper)
        return self.inverse(np.concatenate([inside, start]))

    def _parts(self, x: Array) -> tuple[Array, Array]:
        """Divide an array (…, n) into what belongs to the equations and to the noise model."""
        n = len(self.parametrisation.free)
        return x[..., :n], x[..., n:]

    def log_prior(self, eta: Array) -> Array:
        """Return the log prior density of η up to a constant.

        Parameters
        ----------
        eta
            Coordinates, shape (n_sets, n).

        Returns
        -------
        ndarray, shape (n_sets,)
            −inf outside the bounds and where an ordering is violated.
        """
        lower, upper = self.bounds()
        theta, own = self.thetas(eta), self._parts(eta)[0]
        inside = np.all((eta >= lower) & (eta <= upper), axis=-1) & self.parametrisation.meets_orderings(theta)
        total = np.where(inside, 0.0, -np.inf)
        log_slope = self.parametrisation.log_slope(own)
        for i, (place, quantity) in enumerate(zip(self.parametrisation.free, self.free, strict=True)):
            if quantity.prior is not None:
                deviation = (theta[..., place] - quantity.prior.mean) / (self.widen * quantity.prior.std)
                total = total - 0.5 * deviation**2
            # A prior in x takes the factor dx/dη; a prior flat in log x is flat in its coordinate.
            if quantity.prior is not None or quantity.scale != "log":
                total = total + log_slope[..., i]
        for i, h in enumerate(self.hyper):
            total = total + h.prior.widen(self.widen).log_density(eta[..., len(self.free) + i])
        return np.asarray(total)

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw η from the prior, and reject what lies outside bounds and orderings.

        Parameters
        ----------
        rng
            Source of the random numbers.
        size
            Number of draws.

        Returns
        -------
        ndarray, shape (size, n)
        """
        kept = np.empty((0, self.size))
        while len(kept) < size:
            # Four times the number that is wanted, because some draws are rejected.
            columns = [
                _draw_quantity(q, log, self.widen, rng, 4 * size)
                for q, log in zip(self.free, self.parametrisation.log, strict=True)
            ]
            columns += [h.prior.widen(self.widen).draw(rng, 4 * size) for h in self.hyper]
            drawn = np.stack(columns, axis=1)
            kept = np.concatenate([kept, drawn[np.isfinite(self.log_prior(drawn))]])
        return kept[:size]


def _draw_quantity(quantity: Quantity, log: bool, widen: float, rng: np.random.Generator, size: int) -> Array:
    """Draw the coordinate of a parameter, a logarithm where ``log``, from its prior without bounds, shape (size,)."""
    if quantity.prior is not None:
        value = quantity.prior.mean + widen * quantity.prior.std * rng.standard_normal(size)
    elif quantity.scale == "log":
        return rng.uniform(np.log(quantity.lower), np.log(quantity.upper), size)
    else:
        value = rng.uniform(quantity.lower, quantity.upper, size)
    return np.log(np.maximum(value, 1e-300)) if log else value


def prior_words(quantity: Quantity) -> str:
    """Write the prior of a parameter in words, as a report shows it.

    Parameters
    ----------
    quantity
        Free parameter.

    Returns
    -------
    str
        Normal with mean and standard deviation, or flat, and the interval, in the parameter's unit.
    """
    interval = f"[{quantity.lower:.3g}, {quantity.upper:.3g}]"
    if quantity.prior is not None:
        return f"normal, {quantity.prior.mean:.4g} ± {quantity.prior.std:.2g}, in {interval}"
    return f"flat in {'log ' if quantity.scale == 'log' else ''}{quantity.id} on {interval}"
