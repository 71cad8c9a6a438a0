"""Log-likelihood of a run for many parameter sets: `Terms`, parameters and simulated positions in, densities out.

The initial states and the amplitudes of cycles and runs are normal coefficients of a few columns and are marginalised
analytically (`noise.marginal`). The parameters of the noise model themselves stay arguments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.noise.gram import correlated_gram, weigh_white, white_products
from haptid.noise.marginal import log_marginal
from haptid.noise.noise_model import NoiseModel
from haptid.noise.terms import Terms, column_scales
from haptid.uq.density.equilibrium import equilibrium

Keep = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Misfit:
    """What parameter sets leave of a run, before a noise model's parameters weigh it.

    A climb in the noise parameters alone asks for many densities of one misfit.

    Parameters
    ----------
    terms
        The run, linearised.
    model
        Random parts of the data.
    residual
        Measured minus simulated, less the centre of the initial states' prior [rad], shape (n_sets, n_t).
    motion
        Simulated minus equilibrium [rad], shape (n_sets, n_t); the simulated position without scatter of the reading.
    keep
        Rows that count, shape (n_t,).
    products
        Inner products of [residual, random columns] under white noise of 1 rad, shape (n_sets, 1 + k, 1 + k); None
        under correlated noise, whose time enters them.
    """

    terms: Terms
    model: NoiseModel
    residual: Array
    motion: Array
    keep: Keep
    products: Array | None

    @classmethod
    def of(
        cls, terms: Terms, model: NoiseModel, equations: Equations, thetas: Array, simulated: Array,
        keep: Keep | None = None,
    ) -> Misfit:  # fmt: skip
        """Take the misfit of simulations.

        Parameters
        ----------
        terms
            The run, linearised.
        model
            Random parts of the data.
        equations
            Equations of the free joint, for its equilibrium.
        thetas
            Parameter sets, shape (n_sets, n_p).
        simulated
            Positions at ``thetas`` [rad], shape (n_sets, n_t).
        keep
            Rows that count, shape (n_t,); all where None.

        Returns
        -------
        Misfit
        """
        seen = np.ones(terms.run.t.size, dtype=bool) if keep is None else keep
        residual = terms.data - simulated
        rest = (
            equilibrium(equations, thetas, float(terms.data.mean()))
            if model.scatter == "reading"
            else np.zeros(len(thetas))
        )
        motion = simulated - rest[:, None]  # only the scatter of the reading uses it: else no equilibrium is solved
        # The prior of the start is centred on the first sample: shift the residual to that centre.
        residual = residual - terms.start_shift @ terms.fixed[: len(terms.states)]
        products = None if model.correlated else white_products(terms, model, residual, motion, seen)
        return cls(terms=terms, model=model, residual=residual, motion=motion, keep=seen, products=products)

    def gram(self, hyper: dict[str, Array]) -> tuple[Array, Array]:
        """Return the Gram matrix of [residual, random columns] under the inverse noise covariance.

        Parameters
        ----------
        hyper
            Values of the noise model's parameters by id, shape (n_sets,) each.

        Returns
        -------
        gram : ndarray, shape (n_sets, 1 + k, 1 + k)
            The columns in the order of `column_scales`.
        logdet : ndarray, shape (n_sets,)
            log det of the noise covariance.
        """
        noise = hyper["noise_factor"] * self.terms.sensor_std
        if self.products is not None:
            return weigh_white(self.products, noise, self.keep)
        error = (hyper["model_error"], hyper["error_time"])
        return correlated_gram(self.terms, self.model, self.residual, self.motion, noise, error, self.keep)

    def log_likelihood(self, hyper: dict[str, Array]) -> Array:
        """Return the log marginal likelihood of the rows in ``keep``.

        Parameters
        ----------
        hyper
            Values of the noise model's parameters by id, shape (n_sets,) each.

        Returns
        -------
        ndarray, shape (n_sets,)
            Of no use where a simulation diverged.
        """
        gram, logdet = self.gram(hyper)
        return log_marginal(gram, column_scales(self.terms, self.model, hyper), logdet, int(self.keep.sum()))


def log_likelihood(
    terms: Terms, model: NoiseModel, equations: Equations, thetas: Array, hyper: dict[str, Array], simulated: Array,
    keep: Keep | None = None,
) -> Array:  # fmt: skip
    """Return the log marginal likelihood of the rows in ``keep``.

    Parameters
    ----------
    terms, model, equations, thetas, simulated, keep
        As in `Misfit.of`.
    hyper
        Values of the noise model's parameters by id, shape (n_sets,) each.

    Returns
    -------
    ndarray, shape (n_sets,)
        −inf where a simulation diverged.
    """
    finite: Keep = np.all(np.isfinite(simulated), axis=1)
    safe = np.where(finite[:, None], simulated, 0.0)
    value = Misfit.of(terms, model, equations, thetas, safe, keep).log_likelihood(hyper)
    return np.where(finite, value, -np.inf)


def predictive_score(
    terms: Terms, model: NoiseModel, equations: Equations, thetas: Array, hyper: dict[str, Array], simulated: Array
) -> Array:
    """Return the log density of a held-out run's scored rows given the rows before them.

    Parameters
    ----------
    terms, model, equations, thetas, hyper, simulated
        As in `log_likelihood`.

    Returns
    -------
    ndarray, shape (n_sets,)
        log p(y) − log p(rows before ``run.score_from``); log p(y) where every row is scored.
    """
    total = log_likelihood(terms, model, equations, thetas, hyper, simulated)
    if terms.run.score_from == 0:
        return total
    before = np.arange(terms.run.t.size) < terms.run.score_from
    return np.asarray(total - log_likelihood(terms, model, equations, thetas, hyper, simulated, before))


def cycle_scores(
    terms: Terms, model: NoiseModel, equations: Equations, thetas: Array, hyper: dict[str, Array], simulated: Array
) -> Array:
    """Return the log density of every cycle given all other cycles of its run.

    Parameters
    ----------
    terms, model, equations, thetas, hyper, simulated
        As in `log_likelihood`.

    Returns
    -------
    ndarray, shape (n_sets, n_cycles)
        log p(y) − log p(y₋c), y₋c the run without the rows of cycle c.
    """
    total = log_likelihood(terms, model, equations, thetas, hyper, simulated)
    without = [
        log_likelihood(terms, model, equations, thetas, hyper, simulated, terms.cycle != c) for c in range(terms.cycles)
    ]
    return np.asarray(total[:, None] - np.array(without).T)
