"""SLSQP on the logarithm of the mean square, in variables in which the Gauss–Newton Hessian is the identity.

f(x) = ln(‖r‖²/N), ∇f = 2·Jᵀr/‖r‖². With x = x₀ + T·w and T from JᵀJ at the start, ∂²f/∂w² ≈ 1: SLSQP (Kraft 1988) begins with
the right curvature instead of learning it. Bounds and orderings become linear inequalities in w.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from identification.gauss_newton import RIDGE, Descent
from identification.least_squares import triangle
from identification.passivity import passivity
from identification.problem import Problem
from measurement.run import Array

ROUND = 8
"""Iterations in one set of variables."""
WORST = 80.0
"""Value of f where a simulation left the finite numbers."""


class _Cost:
    """f and ∇f in w, counting calls; remembers the best point."""

    def __init__(self, problem: Problem, x: Array, gain: float) -> None:
        self.problem, self.gain, self.x, self.calls = problem, gain, x, 0
        now = self._blocks(x)
        r, J = now.residual, now.jacobian
        self.best, self.cost = x, float(r @ r)
        R, _ = triangle(J, r)
        columns = np.linalg.norm(R, axis=0)
        R, _ = triangle(np.vstack((R, np.eye(x.size) * RIDGE * columns.max())), np.zeros(2 * x.size))
        self.T = solve_triangular(R, np.eye(x.size)) * np.sqrt(self.cost / 2.0)

    def _blocks(self, x: Array) -> Any:
        self.calls += 1
        return self.problem.blocks(x, self.gain)

    def point(self, w: Array) -> Array:
        return self.x + self.T @ w

    def __call__(self, w: Array) -> tuple[float, Array]:
        x = self.point(w)
        now = self._blocks(x)
        r = now.residual
        cost = float(r @ r)
        if not np.isfinite(cost):
            return WORST, np.zeros_like(w)
        if cost < self.cost:
            self.best, self.cost = x, cost
        return float(np.log(cost / self.problem.weight)), self.T.T @ (2.0 * (now.jacobian.T @ r) / cost)


def slsqp(problem: Problem, x: Array, gain: float = 0.0, *, iterations: int = 60, tolerance: float = 1e-9) -> Descent:
    """Minimise from ``x``, which must be feasible; the best point seen is returned.

    The variables are taken anew every `ROUND` iterations: the curvature of LuGre friction changes along the way.
    """
    calls, before = 0, np.inf
    while calls < iterations:
        cost = _Cost(problem, x, gain)
        if not np.isfinite(cost.cost):
            break
        before = cost.cost
        success = _round(cost, tolerance)
        x, calls = cost.best, calls + cost.calls
        if before - cost.cost <= tolerance * cost.cost:
            return Descent(x=x, cost=cost.cost, calls=calls, converged=success)
    return Descent(x=x, cost=cost.cost, calls=calls, converged=False)


def _round(cost: _Cost, tolerance: float) -> bool:
    problem = cost.problem
    A, b = problem.constraints()
    G, h = A @ cost.T, A @ cost.x - b
    constraints: list[dict[str, Any]] = [{"type": "ineq", "fun": lambda w: G @ w + h, "jac": lambda _: G}]
    if problem.options.passive:
        constraints.append(passivity(problem, cost.point, cost.T))
    done = minimize(
        cost,
        np.zeros(cost.x.size),
        jac=True,
        method="SLSQP",
        constraints=constraints,
        options={"maxiter": ROUND, "ftol": tolerance},
    )
    return bool(done.success)
