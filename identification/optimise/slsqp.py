"""SLSQP on the logarithm of the mean square, in variables in which the Gauss–Newton Hessian is the identity.

f(x) = ln(‖r‖²/N), ∇f = 2·Jᵀr/‖r‖². With x = x₀ + T·w, (T·Tᵀ)⁻¹ = 2·JᵀJ/‖r‖² + λ·1 at the start: SLSQP (Kraft 1988)
begins with the right curvature instead of learning it, and λ keeps its first steps short where the data say little.
Bounds and orderings become linear inequalities in w.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from haptid.identification.optimise.levenberg_marquardt import Descent, cost_of
from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.problem.passivity import passivity
from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.retraction import Retraction
from haptid.measurement.values.run import Array

WORST = 80.0
"""Value of f where a simulation left the finite numbers."""


class _Cost:
    """f and ∇f in w, counting calls; remembers the best point."""

    def __init__(self, problem: Problem, x: Array, gain: float, damping: float) -> None:
        self.problem, self.gain, self.x, self.calls = problem, gain, x, 0
        self.along = Retraction.of(problem)
        now = self._blocks(x)
        self.best, self.cost = x, cost_of(now)
        if not np.isfinite(self.cost):
            return
        R, _ = triangle(now.jacobian, now.residual)
        curvature = np.vstack((R * np.sqrt(2.0 / self.cost), np.sqrt(damping) * np.eye(x.size)))
        self.T = solve_triangular(np.linalg.qr(curvature, mode="r"), np.eye(x.size))

    def _blocks(self, x: Array) -> Any:
        self.calls += 1
        return self.problem.blocks(x, self.gain)

    def point(self, w: Array) -> Array:
        return self.along.move(self.x, self.T @ w)

    def tangent(self, w: Array) -> Array:
        """Return dx/dw, shape (n, n)."""
        return self.along.slope(self.x, self.T @ w) @ self.T

    def __call__(self, w: Array) -> tuple[float, Array]:
        x = self.point(w)
        now = self._blocks(x)
        r, cost = now.residual, cost_of(now)
        if not np.isfinite(cost):
            return WORST, np.zeros_like(w)
        if cost < self.cost:
            self.best, self.cost = x, cost
        return float(np.log(cost / self.problem.weight)), self.tangent(w).T @ (2.0 * (now.jacobian.T @ r) / cost)


def slsqp(
    problem: Problem,
    x: Array,
    gain: float = 0.0,
    *,
    iterations: int = 60,
    tolerance: float = 1e-9,
    damping: float = 1e-3,
) -> Descent:
    """Minimise from ``x``, which must be feasible; the best point seen is returned.

    Where SLSQP stops by itself, it is started anew in fresh variables until that no longer helps.
    """
    calls = 0
    while True:
        cost = _Cost(problem, x, gain, damping)
        if not np.isfinite(cost.cost):
            return Descent(x=x, cost=cost.cost, calls=calls, converged=False)
        before = cost.cost
        success = _minimise_once(cost, iterations - calls, tolerance)
        x, calls = cost.best, calls + cost.calls
        small = before - cost.cost <= 10.0 * tolerance * cost.cost
        if small or calls >= iterations:
            return Descent(x=x, cost=cost.cost, calls=calls, converged=success and small)


def _minimise_once(cost: _Cost, iterations: int, tolerance: float) -> bool:
    """Run SLSQP once from w = 0 and say whether it met its tolerance."""
    problem = cost.problem
    A, slack = cost.along.constraints(cost.x)
    G, h = A @ cost.T, -slack
    constraints: list[dict[str, Any]] = [{"type": "ineq", "fun": lambda w: G @ w + h, "jac": lambda _: G}]
    if problem.options.passive:
        constraints.append(passivity(problem, cost.point, cost.tangent))
    done = minimize(
        cost,
        np.zeros(cost.x.size),
        jac=True,
        method="SLSQP",
        constraints=constraints,
        options={"maxiter": iterations, "ftol": tolerance},
    )
    return bool(done.success)
