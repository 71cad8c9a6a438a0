"""Define least-squares problems with correlated noise: simulator, `Run`s and `Whitener`s in, `Whitened` problem out.

Residual and Jacobian of a run are whitened as a whole, since amplitude scatter correlates rows that lie far apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.study.channels import scored_rows
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Whitener

OPTIONS = FitOptions(method="gauss_newton", weights=(1.0, 1.0))
"""Options that weight every row once: the time weights of a fit would invalidate the statistics of the residual."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Whitened(Problem):
    """A least-squares problem whose residuals have covariance 1 under the noise model.

    Parameters
    ----------
    whiteners
        One whitener for every run.
    """

    whiteners: tuple[Whitener, ...] = ()

    @classmethod
    def under(
        cls, simulator: Simulator, runs: tuple[Run, ...], whiteners: tuple[Whitener, ...], *, threads: int = 1
    ) -> Whitened:
        """Lay out the unknowns of ``runs`` under a noise model.

        Parameters
        ----------
        simulator
            Simulator of the model.
        runs
            Runs whose residuals are fitted.
        whiteners
            One whitener for every run.
        threads
            Number of threads that simulate runs side by side.

        Returns
        -------
        Whitened
            Problem that weights every row once.
        """
        plain = Problem.of(simulator, runs, OPTIONS)
        names = ("simulator", "parametrisation", "runs", "starts", "roots", "options")
        return cls(**{name: getattr(plain, name) for name in names}, whiteners=whiteners, threads=threads)

    def blocks(self, x: Array, gain: float = 0.0, *, jacobian: bool = True) -> Blocks:
        """Simulate every run at ``x`` and whiten residuals and Jacobians.

        Parameters
        ----------
        x
            Scaled unknowns, shape (n,).
        gain
            Observer gain [1/s].
        jacobian
            Whether to compute the Jacobians.

        Returns
        -------
        Blocks
            Whitened residuals (n_t, n_joints) and Jacobians (n_t, n_joints, n) of every run, and those of the priors.
        """
        return self.whiten_blocks(Problem.blocks(self, x, gain, jacobian=jacobian))

    def whiten_blocks(self, found: Blocks) -> Blocks:
        """Whiten residuals and Jacobians of every run.

        Parameters
        ----------
        found
            Residuals over the sensor's standard deviation and their Jacobians.

        Returns
        -------
        Blocks
            Whitened rows of the runs; those of the priors are white already and stay as they are.
        """
        rows = tuple(w(r) for w, r in zip(self.whiteners, found.rows, strict=True))
        slopes = None
        if found.jacobians is not None:
            slopes = tuple(w(J) for w, J in zip(self.whiteners, found.jacobians, strict=True))
        return Blocks(rows=rows, jacobians=slopes, prior=found.prior, prior_jacobian=found.prior_jacobian)

    def constraints(self) -> tuple[Array, Array]:
        """Return A and b of the constraints A·x ≥ b.

        Returns
        -------
        A, b
            Shapes (n_constraints, n) and (n_constraints,); without rows where all parameters are fixed and only initial
            states are fitted.
        """
        if self.n_parameters == 0:
            return np.zeros((0, self.size)), np.zeros(0)
        return Problem.constraints(self)

    @property
    def log_determinant(self) -> float:
        """Sum of ln det C over the runs, C the covariance of a run's residuals over the sensor's std."""
        pairs = zip(self.whiteners, self.runs, strict=True)
        return sum(w.log_determinant(scored_rows(run)) for w, run in pairs)
