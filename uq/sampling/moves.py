"""Moves of the sampler: emcee's own, and independent draws of a Student distribution around the ensembles' mean.

References
----------
Goodman, J., and Weare, J. (2010). Ensemble samplers with affine invariance. Communications in Applied Mathematics and
Computational Science 5, 65–80.
ter Braak, C. J. F. (2006). A Markov chain Monte Carlo version of the genetic algorithm differential evolution.
Statistics and Computing 16, 239–249.
ter Braak, C. J. F., and Vrugt, J. A. (2008). Differential evolution Markov chain with snooker updater and fewer
chains. Statistics and Computing 18, 435–446.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import emcee
import numpy as np

from haptid.measurement.values.run import Array
from haptid.uq.thresholds import THRESHOLDS

MOVES = ("stretch", "differential", "independent")
"""Names of the moves, in the order in which the ensembles of the pilot try them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposal:
    """Multivariate Student distribution: proposals independent of the walkers.

    It has ν = `THRESHOLDS.degrees_of_freedom_of_proposals` degrees of freedom.

    Parameters
    ----------
    mean
        Centre, shape (n,).
    lower
        Lower Cholesky factor L of the scale matrix L·Lᵀ, shape (n, n).
    """

    mean: Array
    lower: Array

    @classmethod
    def of(cls, mean: Array, covariance: Array) -> Proposal:
        """Make a proposal of mean and covariance.

        Parameters
        ----------
        mean
            Centre, shape (n,).
        covariance
            Scale matrix, shape (n, n); its diagonal is raised by 1e-9 of itself against singularity.

        Returns
        -------
        Proposal

        Raises
        ------
        numpy.linalg.LinAlgError
            Where the raised matrix is not positive definite.
        """
        lifted = covariance + np.diag(1e-9 * np.diag(covariance) + 1e-300)
        return cls(mean=mean, lower=np.asarray(np.linalg.cholesky(lifted), dtype=np.float64))

    def log_density(self, x: Array) -> Array:
        """Return the log density up to a constant.

        Parameters
        ----------
        x
            Points, shape (n_sets, n).

        Returns
        -------
        ndarray, shape (n_sets,)
            −(ν + n)/2·ln(1 + ‖L⁻¹·(x − mean)‖²/ν) for n dimensions: a multivariate Student t.
        """
        z = np.linalg.solve(self.lower, (x - self.mean).T)
        nu = THRESHOLDS.degrees_of_freedom_of_proposals
        return np.asarray(-0.5 * (nu + self.mean.size) * np.log1p(np.sum(z**2, axis=0) / nu))

    def draw(self, random: Any, size: int) -> Array:
        """Draw independent points: normal draws over √(χ²/ν).

        Parameters
        ----------
        random
            NumPy random state.
        size
            Number of points.

        Returns
        -------
        ndarray, shape (size, n)
        """
        nu = THRESHOLDS.degrees_of_freedom_of_proposals
        normal = random.randn(size, self.mean.size)
        scale = np.sqrt(random.chisquare(nu, size) / nu)
        return np.asarray(self.mean + (normal / scale[:, None]) @ self.lower.T)

    def __call__(self, coords: Array, random: Any) -> tuple[Array, Array]:
        """Propose new points for walkers, as `emcee.moves.MHMove` asks.

        Parameters
        ----------
        coords
            Present positions, shape (n_walkers, n).
        random
            NumPy random state.

        Returns
        -------
        new : ndarray, shape (n_walkers, n)
            Independent draws.
        log_ratio : ndarray, shape (n_walkers,)
            Log of the Metropolis–Hastings factor p(present)/p(new) of the proposal's density.
        """
        new = self.draw(random, coords.shape[0])
        return new, self.log_density(coords) - self.log_density(new)


Weighted = list[tuple[Any, float]]


def moves(name: str, proposal: Proposal) -> Weighted:
    """Return emcee's moves with their weights.

    Parameters
    ----------
    name
        One of `MOVES`. ``stretch``: Goodman and Weare (2010), section 2. ``differential``: ter Braak (2006), in one
        step of five the snooker of ter Braak and Vrugt (2008). ``independent``: in seven steps of ten all walkers
        propose draws of ``proposal``, else ``differential``.
    proposal
        Distribution of the independent draws.

    Returns
    -------
    list of tuple
        emcee's move and its share of the steps [1]; the shares add up to 1.

    Raises
    ------
    KeyError
        For a name that is not in `MOVES`.
    """
    builders: dict[str, Callable[[], Weighted]] = {
        "stretch": lambda: [(emcee.moves.StretchMove(), 1.0)],
        "differential": lambda: [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)],
        "independent": lambda: [
            (emcee.moves.MHMove(proposal), 0.7),
            (emcee.moves.DEMove(), 0.22),
            (emcee.moves.DESnookerMove(), 0.08),
        ],
    }
    return builders[name]()
