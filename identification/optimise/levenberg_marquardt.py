"""Levenberg–Marquardt under bounds and orderings: each step is a damped linear least-squares problem with inequalities.

Steps are damped in the scale of the Jacobian's own columns (Marquardt 1963; damping after Nielsen 1999: the gain ratio
of a step sets the next one). No fixed ridge holds directions that the data see little of, so that long valleys (gravity
and spring) are walked to the end. Steps follow the valley of `identification.problem.retraction` and respect bounds and
orderings as `identification.problem.bounded_lsq` does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.bounded_lsq import step_within, triangle
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.problem.retraction import Retraction
from haptid.measurement.values.run import Array

FLOOR = 1e-10
"""Least damping: keeps a direction that the data do not see at all from making the step singular."""
ROOF = 1e9
"""Damping at which no step is left to try."""
FAR = 1e4
"""Squares beyond one a row, over which the tolerance grows with them: where so much more than noise is left, nothing is
told by less, and Gauss-Newton steps creep."""
STALLED = 10
"""Simulations in a row that have to bring the tolerance each, on average."""
ACCEPTED = 1e-4
"""Least share of the predicted decrease that a step must bring."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """Where a minimiser stopped: x (n,), cost ‖r‖², calls of the simulations, and whether it met its tolerance."""

    x: Array
    cost: float
    calls: int
    converged: bool


def minimise(
    problem: Problem,
    x: Array,
    gain: float = 0.0,
    *,
    iterations: int = 40,
    tolerance: float = 0.01,
    relative: float = 0.0,
    damping: float = 1e-3,
) -> Descent:
    """Minimise ‖r(x)‖² from ``x``.

    Parameters
    ----------
    problem, x
        What is minimised, and where it begins, shape (n,).
    gain
        Observer gain L [1/s].
    iterations
        Most simulations of all runs.
    tolerance, relative
        It stops where the predicted decrease is below ``tolerance`` (squares over the noise, growing where far more
        than noise is left, see `FAR`) or below the share ``relative`` of the cost. `STALLED` simulations that bring
        less end it too.
    damping
        Damping of the first step.

    Notes
    -----
    Along a narrow valley a damped step promises little however far the minimum is. So where it does, the step without
    damping has to promise as little, or else is tried.
    """
    along = Retraction.of(problem)
    now = problem.blocks(x, gain)
    cost, growth, calls, converged, freed = cost_of(now), 2.0, 1, False, False
    if not np.isfinite(cost):
        return Descent(x=x, cost=cost, calls=calls, converged=False)
    R, c = triangle_by_runs(now)
    costs = [cost]
    while calls < iterations:
        limits = along.constraints(x)
        enough = max(tolerance * max(1.0, (cost - now.residual.size) / FAR), relative * cost)
        d, predicted = _step(R, c, damping, *limits)
        if predicted <= enough and not freed:
            freed, damping = True, FLOOR
            d, predicted = _step(R, c, damping, *limits)
        stalled = len(costs) > STALLED and costs[-STALLED - 1] - cost < STALLED * enough
        converged = stalled or (predicted <= enough and damping < 1.0)
        if converged or damping > ROOF:
            break
        moved = along.move(x, d)
        trial = problem.blocks(moved, gain)
        calls += 1
        new = cost_of(trial)
        ratio = (cost - new) / max(predicted, 1e-12) if np.isfinite(new) else -1.0
        if ratio > ACCEPTED:
            x, cost, growth, freed = moved, new, 2.0, False
            R, c = triangle_by_runs(trial)
            damping = max(damping * max(0.1, 1.0 - (2.0 * ratio - 1.0) ** 3), FLOOR)
        else:
            damping, growth = max(damping, 1e-6) * growth, 2.0 * growth
        costs.append(cost)
    return Descent(x=x, cost=cost, calls=calls, converged=converged)


def cost_of(blocks: Blocks) -> float:
    """Return ‖r‖², infinite where a residual or a derivative is not a finite number."""
    r = blocks.residual
    finite = np.isfinite(r).all() and all(np.isfinite(J).all() for J in blocks.jacobians or ())
    return float(r @ r) if finite else float("inf")


def triangle_by_runs(blocks: Blocks) -> tuple[Array, Array]:
    """Return R, c as `triangle` does for all rows, by QR run after run (Golub and Van Loan 2013, section 5.2).

    A run's rows do not depend on the initial states of the others: those columns are left out of its QR.
    """
    parts, targets = [blocks.prior_jacobian], [blocks.prior]
    for J, r in zip(blocks.jacobians or (), blocks.rows, strict=True):
        flat = J.reshape(-1, J.shape[-1])
        moved = np.flatnonzero(flat.any(axis=0))
        R, c = triangle(flat[:, moved], r.ravel())
        part = np.zeros((moved.size, flat.shape[1]))
        part[:, moved] = R
        parts.append(part)
        targets.append(-c)
    return triangle(np.concatenate(parts), np.concatenate(targets))


def _step(R: Array, c: Array, damping: float, A: Array, slack: Array) -> tuple[Array, float]:
    """Return the step and the decrease of the cost that the linear model predicts for it."""
    columns = np.maximum(np.linalg.norm(R, axis=0), 1e-12 * max(float(np.abs(R).max()), 1e-300))
    damped, target = triangle(
        np.vstack((R, np.diag(np.sqrt(damping) * columns))), -np.concatenate((c, np.zeros_like(c)))
    )
    d = step_within(damped, target, A, np.minimum(slack, 0.0))
    left = c - R @ d
    return d, float(c @ c - left @ left)
