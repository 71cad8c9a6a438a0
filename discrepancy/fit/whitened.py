"""A least-squares problem with correlated noise: residual and Jacobian of a run are whitened as a whole."""

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
"""Every row counts once: the time weights of a fit would spoil the statistics."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Whitened(Problem):
    """A problem whose residuals have covariance 1 under the noise model."""

    whiteners: tuple[Whitener, ...] = ()

    @classmethod
    def under(
        cls, simulator: Simulator, runs: tuple[Run, ...], whiteners: tuple[Whitener, ...], *, threads: int = 1
    ) -> Whitened:
        """Lay out the unknowns of ``runs`` under these whiteners; runs are simulated on ``threads`` threads."""
        plain = Problem.of(simulator, runs, OPTIONS)
        names = ("simulator", "scaling", "runs", "starts", "roots", "options")
        return cls(**{name: getattr(plain, name) for name in names}, whiteners=whiteners, threads=threads)

    def blocks(self, x: Array, gain: float = 0.0, *, jacobian: bool = True) -> Blocks:
        """Simulate every run at x and whiten."""
        return self.whitened(Problem.blocks(self, x, gain, jacobian=jacobian))

    def whitened(self, found: Blocks) -> Blocks:
        """Whiten the residuals and Jacobians of every run."""
        rows = tuple(w(r) for w, r in zip(self.whiteners, found.rows, strict=True))
        slopes = None
        if found.jacobians is not None:
            slopes = tuple(w(J) for w, J in zip(self.whiteners, found.jacobians, strict=True))
        return Blocks(rows=rows, jacobians=slopes, prior=found.prior, prior_jacobian=found.prior_jacobian)

    def constraints(self) -> tuple[Array, Array]:
        """Return A, b of A·x ≥ b; nothing where every parameter is held and only initial states are fitted."""
        if self.n_parameters == 0:
            return np.zeros((0, self.size)), np.zeros(0)
        return Problem.constraints(self)

    @property
    def log_determinant(self) -> float:
        """Sum of ln det C over the runs."""
        pairs = zip(self.whiteners, self.runs, strict=True)
        return sum(w.log_determinant(scored_rows(run)) for w, run in pairs)
