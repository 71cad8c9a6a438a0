"""SLSQP on the logarithm of the mean square: `Problem` and first unknowns in, `Descent` out.

1. At x₀ choose variables w with x = x₀ + T·w and (T·Tᵀ)⁻¹ = 2·JᵀJ/‖r‖² + λ·1: the Gauss–Newton Hessian becomes the
   identity, SLSQP (Kraft 1988) begins with the right curvature instead of learning it, and λ keeps its first steps
   short where the data say little.
2. Minimise f(w) = ln(‖r‖²/N), ∇f = (dx/dw)ᵀ·2·Jᵀr/‖r‖², N the sum of the weights; bounds and orderings are linear
   inequalities in w.
3. Start again at the best point with new variables, until the cost no longer falls.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from haptid.identification.optimise.levenberg_marquardt import Descent, Simulated, cost_of, ignore_simulation
from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.problem.passivity import passivity
from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.retraction import Retraction
from haptid.measurement.values.run import Array

VALUE_WHERE_NOT_FINITE = 80.0
"""Value of f [1] where a simulation is not finite."""


class _Cost:
    """Compute f and ∇f in w, count the simulations and keep the best point."""

    def __init__(self, problem: Problem, x: Array, gain: float, damping: float, tell: Simulated) -> None:
        self.problem, self.gain, self.x, self.calls, self.tell = problem, gain, x, 0, tell
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
            return VALUE_WHERE_NOT_FINITE, np.zeros_like(w)
        if cost < self.cost:
            self.best, self.cost = x, cost
        self.tell(self.calls, self.cost)
        return float(np.log(cost / self.problem.weight)), self.tangent(w).T @ (2.0 * (now.jacobian.T @ r) / cost)


def slsqp(
    problem: Problem,
    x: Array,
    gain: float = 0.0,
    *,
    iterations: int = 60,
    tolerance: float = 1e-9,
    damping: float = 1e-3,
    tell: Simulated = ignore_simulation,
) -> Descent:
    """Minimise ‖r(x)‖² under bounds and orderings by SLSQP, started again until the cost no longer falls.

    Parameters
    ----------
    problem
        Problem with residuals r(x); with ``options.passive`` passivity is a constraint too.
    x
        First unknowns, feasible, shape (n,).
    gain
        Observer gain L [1/s].
    iterations
        Number of simulations of all runs after which SLSQP is not started again.
    tolerance
        SLSQP's tolerance of f; ten times of it, as a share of the cost, is a decrease too small for another start.
    damping
        λ, added to the Hessian of f at the beginning of each start.
    tell
        Told after each simulation of all runs.

    Returns
    -------
    Descent
        Best point of all evaluations.
    """
    calls = 0
    while True:
        cost = _Cost(problem, x, gain, damping, tell=partial(_tell_after, tell, calls))
        if not np.isfinite(cost.cost):
            return Descent(x=x, cost=cost.cost, calls=calls, converged=False)
        before = cost.cost
        success = _minimise_once(cost, iterations - calls, tolerance)
        x, calls = cost.best, calls + cost.calls
        small = before - cost.cost <= 10.0 * tolerance * cost.cost
        if small or calls >= iterations:
            return Descent(x=x, cost=cost.cost, calls=calls, converged=success and small)


def _tell_after(tell: Simulated, before: int, calls: int, cost: float) -> None:
    """Tell the simulations of this start after those of the starts before."""
    tell(before + calls, cost)


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
