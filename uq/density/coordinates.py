"""Coordinates η in which the sampler moves: equations and noise model in, η with its prior density out.

η holds the logarithms of positive quantities and the values of the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.noise.hyper import Hyper


@dataclass(frozen=True, slots=True, kw_only=True)
class Coordinates:
    """η = (free parameters of the equations, then the noise model's): log x where ``scale`` is ``log``, else x.

    The prior of a parameter is its normal prior cut at the bounds, or flat between the bounds: in log x where ``scale``
    is ``log``, else in x. Positive quantities move in log x whatever their prior is flat in. Where amplitudes scatter,
    the data do not identify a common factor of inertia, stiffness and damping, and that ridge of the posterior is a
    straight line only in logarithms. The density is 0 where an ordering (Fs ≥ Fc) is violated.

    Parameters
    ----------
    equations
        Equations whose free parameters are sampled.
    hyper
        Parameters of the noise model, which follow those of the equations in η.
    widen
        Factor on the standard deviation of every normal prior and on the width of every noise parameter's prior [1].
    """

    equations: Equations
    hyper: tuple[Hyper, ...]
    widen: float = 1.0

    @property
    def free(self) -> tuple[Quantity, ...]:
        """The parameters that are sampled."""
        return tuple(q for q in self.equations.parameters if not q.fixed)

    @property
    def names(self) -> tuple[str, ...]:
        """Ids in the order of η."""
        return (*(q.id for q in self.free), *(h.id for h in self.hyper))

    @property
    def units(self) -> tuple[str, ...]:
        """Units in the order of η, each of the untransformed value."""
        return (*(q.unit for q in self.free), *(h.unit for h in self.hyper))

    @property
    def logarithmic(self) -> tuple[bool, ...]:
        """Whether each coordinate is a logarithm, in the order of η."""
        return (*(positive(q) for q in self.free), *(True for _ in self.hyper))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    def _positions(self) -> list[int]:
        return [i for i, q in enumerate(self.equations.parameters) if not q.fixed]

    def bounds(self) -> tuple[Array, Array]:
        """Return the bounds of η.

        Returns
        -------
        lower, upper : ndarray, shape (n,) each
            Those of a noise parameter are e⁻²⁵ and e⁵: its prior, not they, is to limit it.
        """
        pairs = [(np.log(_floor(q)), np.log(q.upper)) if positive(q) else (q.lower, q.upper) for q in self.free]
        pairs += [(-25.0, 5.0)] * len(self.hyper)
        lower, upper = np.array(pairs, dtype=np.float64).reshape(-1, 2).T
        return lower, upper

    def values(self, eta: Array) -> Array:
        """Return the untransformed values of η.

        Parameters
        ----------
        eta
            Coordinates, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
            Parameters and noise parameters, in the units of `units`.
        """
        # exp overflows beyond 709: a trial far outside the bounds still has a finite value.
        return np.where(self.logarithmic, np.exp(np.clip(eta, -700, 700)), eta)

    def inverse(self, values: Array) -> Array:
        """Return η of untransformed values, the inverse of `values`.

        Parameters
        ----------
        values
            Parameters and noise parameters, in the units of `units`, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n)
        """
        flags = np.array(self.logarithmic)
        return np.where(flags, np.log(np.where(flags, values, 1.0)), values)

    def thetas(self, eta: Array) -> Array:
        """Return the full parameter sets of the equations, fixed parameters at their initial values.

        Parameters
        ----------
        eta
            Coordinates, shape (…, n).

        Returns
        -------
        ndarray, shape (…, n_p)
            θ in the order of ``equations.parameters``.
        """
        base = np.array([q.initial for q in self.equations.parameters])
        out = np.broadcast_to(base, (*eta.shape[:-1], base.size)).copy()
        out[..., self._positions()] = self.values(eta)[..., : len(self.free)]
        return out

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
        """
        start = np.array([h.start for h in self.hyper]) if hyper is None else hyper
        lowest = np.array([_floor(q) if positive(q) else q.lower for q in self.free])
        inside = np.clip(np.asarray(theta)[self._positions()], lowest, [q.upper for q in self.free])
        return self.inverse(np.concatenate([inside, start]))

    def slopes(self, eta: Array) -> Array:
        """Return dθ/dη of the free parameters at η (n,), shape (n_free,): the value itself of a logarithm, else 1."""
        n = len(self.free)
        return np.where(self.logarithmic[:n], self.values(eta)[:n], 1.0)

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
        total = np.where(np.all((eta >= lower) & (eta <= upper), axis=-1), 0.0, -np.inf)
        theta = self.thetas(eta)
        ids = [q.id for q in self.equations.parameters]
        for greater, smaller in self.equations.orderings:
            if greater in ids and smaller in ids:
                total = np.where(theta[..., ids.index(greater)] >= theta[..., ids.index(smaller)], total, -np.inf)
        for i, quantity in enumerate(self.free):
            if quantity.prior is not None:
                value = theta[..., ids.index(quantity.id)]
                total = total - 0.5 * ((value - quantity.prior.mean) / (self.widen * quantity.prior.std)) ** 2
            # A prior in x, sampled in log x, takes the factor dx/d(log x) = x; its logarithm is the coordinate itself.
            if positive(quantity) and (quantity.prior is not None or quantity.scale != "log"):
                total = total + eta[..., i]
        for i, h in enumerate(self.hyper):
            total = total + h.prior.widened(self.widen).log_density(eta[..., len(self.free) + i])
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
            columns = [_draw_quantity(q, self.widen, rng, 4 * size) for q in self.free]
            columns += [h.prior.widened(self.widen).draw(rng, 4 * size) for h in self.hyper]
            drawn = np.stack(columns, axis=1)
            kept = np.concatenate([kept, drawn[np.isfinite(self.log_prior(drawn))]])
        return kept[:size]


def positive(quantity: Quantity) -> bool:
    """Whether a quantity is positive over its whole range, so that the sampler moves in its logarithm."""
    return quantity.scale == "log" or (quantity.lower >= 0 and quantity.initial > 0)


def _floor(quantity: Quantity) -> float:
    """Return the lower bound, or a billionth of the first guess where the bound is 0 and has no logarithm."""
    return quantity.lower if quantity.lower > 0 else 1e-9 * quantity.initial


def _draw_quantity(quantity: Quantity, widen: float, rng: np.random.Generator, size: int) -> Array:
    if quantity.prior is not None:
        value = quantity.prior.mean + widen * quantity.prior.std * rng.standard_normal(size)
    elif quantity.scale == "log":
        return rng.uniform(np.log(quantity.lower), np.log(quantity.upper), size)
    else:
        value = rng.uniform(quantity.lower, quantity.upper, size)
    return np.log(np.maximum(value, 1e-300)) if positive(quantity) else value


def prior_words(quantity: Quantity) -> str:
    """Write the prior of a parameter in words, as a report shows it."""
    interval = f"[{quantity.lower:.3g}, {quantity.upper:.3g}]"
    if quantity.prior is not None:
        return f"normal, {quantity.prior.mean:.4g} ± {quantity.prior.std:.2g}, in {interval}"
    return f"flat in {'log ' if quantity.scale == 'log' else ''}{quantity.id} on {interval}"
