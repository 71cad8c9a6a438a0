"""Levenberg–Marquardt under bounds and orderings: each step is a damped linear least-squares problem with inequalities.

Nielsen's damping (1999): the gain ratio of a step sets the next damping. The damping is scaled by the columns of the
Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.bounded_lsq import step_within, triangle
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.problem.retraction import Retraction
from haptid.measurement.values.run import Array

RIDGE = 1e-6
"""Regularisation of directions that the data do not see, relative to the largest column of the scaled Jacobian."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """Where a minimiser stopped: x (n,), cost ‖r‖², calls of the simulations, and whether it met its tolerance."""

    x: Array
    cost: float
    calls: int
    converged: bool


def gauss_newton(
    problem: Problem,
    x: Array,
    gain: float = 0.0,
    *,
    iterations: int = 40,
    tolerance: float = 1e-10,
    damping: float = 1e-4,
) -> Descent:
    """Minimise ‖r(x)‖² from ``x``; stop where the predicted decrease is below ``tolerance`` of the cost."""
    along = Retraction.of(problem)
    now = problem.blocks(x, gain)
    cost, growth, calls, converged = cost_of(now), 2.0, 1, False
    if not np.isfinite(cost):
        return Descent(x=x, cost=cost, calls=calls, converged=False)
    R, c = triangle(now.jacobian, now.residual)
    while calls < iterations and not converged:
        d, predicted = _damped_step(R, c, damping, *along.constraints(x))
        converged = predicted <= tolerance * cost
        if converged:
            break
        moved = along.move(x, d)
        trial = problem.blocks(moved, gain)
        calls += 1
        new = cost_of(trial)
        ratio = (cost - new) / predicted if np.isfinite(new) else -1.0
        if ratio > 1e-4:
            x, cost, growth = moved, new, 2.0
            R, c = triangle(trial.jacobian, trial.residual)
            damping = max(damping * max(0.1, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-15)
        else:
            damping, growth = damping * growth, 2.0 * growth
            converged = damping > 1e12
    return Descent(x=x, cost=cost, calls=calls, converged=converged)


def cost_of(blocks: Blocks) -> float:
    """Return ‖r‖², infinite where a residual or a derivative is not a finite number."""
    r = blocks.residual
    finite = np.isfinite(r).all() and all(np.isfinite(J).all() for J in blocks.jacobians or ())
    return float(r @ r) if finite else float("inf")


def _damped_step(R: Array, c: Array, damping: float, A: Array, slack: Array) -> tuple[Array, float]:
    """Return the step and the decrease of the cost that the linear model predicts."""
    columns = np.linalg.norm(R, axis=0)
    ridge = np.sqrt(damping * columns**2 + (RIDGE * columns.max()) ** 2)
    damped, target = triangle(np.vstack((R, np.diag(ridge))), -np.concatenate((c, np.zeros_like(c))))
    d = step_within(damped, target, A, slack)
    left = c - R @ d
    return d, float(c @ c - left @ left)
