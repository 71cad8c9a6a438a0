"""Output-injection homotopy: `Problem` and first unknowns in, `Descent` out.

A free simulation of LuGre friction has false minima next to the true one. Pulled towards the measured position with
gain L [1/s], the simulation stays near the data, the cost has fewer minima, and the minimum moves continuously with L
(`follow_gains`). A fit (`descend`) goes these steps:

1. Move the first unknowns inside bounds and orderings (`feasible`).
2. Minimise at every observer gain of the options, in their order, each level from the minimum of the level
   before; the levels run at a coarser inner step and on fewer rows where the data allow it. A level that ends in a
   corner goes on from beside it (`identification.optimise.corners`). Where the simulation under the last gain is near
   the data already (`is_near_the_data`), no false minimum lies between, and the last level follows at once.
3. Polish the last minimum by Levenberg–Marquardt on all rows, at the model's own inner step (`polish`). Far above the
   noise the coarser problem is polished, and the best of several starts again on all rows
   (`identification.fit.minima`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.optimise.corners import leave_corners
from haptid.identification.optimise.fewer_rows import with_fewer_rows
from haptid.identification.optimise.inner_step import coarsen
from haptid.identification.optimise.levenberg_marquardt import (
    FREE_STEPS,
    Descent,
    Simulated,
    Steps,
    SumOfSquares,
    cost_of,
    ignore_simulation,
    minimise,
)
from haptid.identification.optimise.slsqp import slsqp
from haptid.identification.problem.residuals import Problem
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Tell, tell_nobody
from haptid.measurement.values.run import Array
from haptid.support.numbers import plain

SHARE_OF_SIMULATION = 0.1
"""Share of what is left of a level that one simulation of all runs does, for those who wait [1]."""


def follow_gains(
    start: Descent, gains: Sequence[float], minimise_at: Callable[[Array, float, int], Descent]
) -> Descent:
    """Follow a minimum through observer gains, each minimisation from the minimum under the gain before.

    Parameters
    ----------
    start
        First unknowns, with the simulations so far.
    gains
        Observer gains L [1/s] in the order in which they are used.
    minimise_at
        Function of unknowns (n,), gain and the number of the gain in ``gains`` that minimises under this gain.

    Returns
    -------
    Descent
        Minimum under the last gain, ``start`` where there is no gain; ``calls`` counts those of ``start`` and of all
        gains.
    """
    reached = start
    for number, gain in enumerate(gains):
        before = reached.calls
        reached = minimise_at(reached.x, gain, number)
        reached = replace(reached, calls=before + reached.calls)
    return reached


def descend(problem: Problem, x: Array, tell: Tell = tell_nobody, *, short: bool = True) -> Descent:
    """Follow the minimum from the first observer gain to the last and polish it.

    Parameters
    ----------
    problem
        Problem whose options name gains and method.
    x
        First unknowns, shape (n,).
    tell
        Told the share of the levels that is done, and how large the residual is.
    short
        Whether no step moves a logarithm by more than `THRESHOLDS.longest_step_of_logarithm`: far from where slopes
        were taken they say nothing. Long steps may lead out of a false minimum, or into one.

    Returns
    -------
    Descent
        Minimum at the last gain and the model's own inner step; ``calls`` counts all levels.
    """
    gains, steps = problem.options.gains, Steps.short(problem) if short else FREE_STEPS
    coarse, close = problem, False

    def minimise_level(x: Array, gain: float, number: int) -> Descent:
        nonlocal coarse, close
        # The inner step is chosen far from the minimum and again near it, where a smaller residual asks for more.
        if number in {0, len(gains) - 1}:
            coarse = coarsen(with_fewer_rows(problem, x, gain), x, gain)
        if number == len(gains) - 1:
            return _level(coarse, x, number, near=close, steps=steps, tell=_at_level(coarse, number, tell))
        asked = not close
        close = close or is_near_the_data(coarse, x)
        if close:
            return replace(Descent.at(x), calls=int(asked))
        reached = _level(coarse, x, number, steps=steps, tell=_at_level(coarse, number, tell))
        return replace(reached, calls=reached.calls + asked)

    near = follow_gains(Descent.at(feasible(problem, x)), gains, minimise_level)
    if is_far(coarse, near):
        near = polish(coarse, near, _at_level(coarse, len(gains), tell), short=short)
    if not is_far(coarse, near):
        return polish(problem, near, _at_level(problem, len(gains), tell), short=short)
    cost = cost_of(problem.blocks(near.x, gains[-1], jacobian=False))
    return replace(near, cost=cost, calls=near.calls + 1)


def is_far(problem: Problem, reached: Descent) -> bool:
    """Say whether a minimum is so far above the noise that its residual is a model error.

    No further digit describes the parameters there. So the starts are compared on the coarser problem of their way, and
    the best of them alone is polished on all rows at the model's own inner step.

    Parameters
    ----------
    problem
        Problem on which the cost was computed.
    reached
        Minimum.

    Returns
    -------
    bool
        False where the cost is not finite.
    """
    return bool(THRESHOLDS.excess_cost_of_model_error < reached.cost / problem.weight < np.inf)


def polish(problem: Problem, near: Descent, tell: Simulated = ignore_simulation, *, short: bool = True) -> Descent:
    """Minimise at the last gain from a minimum of a coarser problem.

    Parameters
    ----------
    problem
        Problem with the rows and the inner step of the result.
    near
        Minimum of a coarser problem.
    tell
        Told of each simulation.
    short
        As for `descend`.

    Returns
    -------
    Descent
        Minimum; ``calls`` counts those of ``near`` too.
    """
    gain = problem.options.gains[-1]
    # Levenberg–Marquardt knows bounds and orderings only: under the passivity constraint SLSQP polishes.
    if problem.options.passive:
        polished = slsqp(
            problem,
            near.x,
            gain,
            iterations=THRESHOLDS.most_iterations_of_last_level,
            tolerance=THRESHOLDS.tolerance_of_last_level,
            damping=THRESHOLDS.least_damping_of_slsqp,
            tell=tell,
        )
    else:
        # A few hundred independent parts of a model error determine the parameters.
        polished = minimise(
            SumOfSquares.of(problem, gain),
            near.x,
            iterations=THRESHOLDS.most_iterations_of_last_level,
            tolerance=0.0,
            relative=THRESHOLDS.tolerance_of_polish_far if is_far(problem, near) else THRESHOLDS.tolerance_of_polish,
            steps=Steps.short(problem, damping=1e-9) if short else Steps(damping=1e-9),
            tell=tell,
        )
    return replace(polished, calls=near.calls + polished.calls)


def is_near_the_data(problem: Problem, x: Array) -> bool:
    """Say whether the simulation under the last gain leaves little of the motion, and little above the noise.

    Parameters
    ----------
    problem
        Problem whose options name the gains.
    x
        Unknowns, shape (n,).

    Returns
    -------
    bool
        Whether √(‖r‖²/N) is at most `THRESHOLDS.largest_residual_near_the_data` and at most
        `THRESHOLDS.largest_residual_near_the_data_over_motion` of the motion, both in standard deviations of the noise.
    """
    residual = np.sqrt(cost_of(problem.blocks(x, problem.options.gains[-1], jacobian=False)) / problem.weight)
    motion = np.sqrt(np.mean([np.mean(np.var(run.y, axis=0) / run.sensor_std**2) for run in problem.runs]))
    most = THRESHOLDS.largest_residual_near_the_data_over_motion * motion
    return bool(residual <= min(THRESHOLDS.largest_residual_near_the_data, most))


def _at_level(problem: Problem, number: int, tell: Tell) -> Simulated:
    """Return a function that tells how far a minimiser at a level is; the polish is the last level.

    Nobody knows how many simulations a level takes: each does `SHARE_OF_SIMULATION` of what is left of it.
    """
    levels = len(problem.options.gains) + 1

    def tell_level(calls: int, cost: float) -> None:
        share = (number + 1.0 - (1.0 - SHARE_OF_SIMULATION) ** calls) / levels
        tell(share, f"level {number + 1} of {levels}, {plain(float(np.sqrt(cost / problem.weight)))} times the noise")

    return tell_level


def _level(  # what is minimised, where it begins, how far it steps, and who listens
    problem: Problem,
    x: Array,
    number: int,
    *,
    near: bool = False,
    steps: Steps,
    tell: Simulated = ignore_simulation,
) -> Descent:
    """Minimise at one gain; ``near`` says whether x leaves little of the motion."""
    gains = problem.options.gains
    last = number == len(gains) - 1
    iterations, tolerance = THRESHOLDS.most_iterations_of_early_level, THRESHOLDS.tolerance_of_early_level
    if last:
        iterations, tolerance = THRESHOLDS.most_iterations_of_last_level, THRESHOLDS.tolerance_of_last_level
    cost = SumOfSquares.of(problem, gains[number])

    def minimise_from(x: Array) -> Descent:
        # Near the data Levenberg–Marquardt converges quadratically, SLSQP in three to five times as many simulations.
        if problem.options.method == "gauss_newton" or (near and not problem.options.passive):
            return minimise(cost, x, iterations=iterations, tolerance=0.0, relative=tolerance, steps=steps, tell=tell)
        # Strong damping in the first levels, where the parameters may be far from the minimum.
        damping = max(0.1**number, THRESHOLDS.least_damping_of_slsqp)
        return slsqp(problem, x, gains[number], iterations=iterations, tolerance=tolerance, damping=damping, tell=tell)

    relative = THRESHOLDS.tolerance_of_early_level
    return leave_corners(cost, minimise_from(x), minimise_from, steps=steps, relative=relative)


def feasible(problem: Problem, x: Array) -> Array:
    """Move the unknowns strictly inside bounds and orderings.

    Parameters
    ----------
    problem
        Problem with bounds and orderings.
    x
        Unknowns, shape (n,).

    Returns
    -------
    ndarray, shape (n,)
        x with its parameters at least 1e-6 of the range from finite bounds, and moved along the gradient of each
        ordering that is not met by 1e-3.
    """
    lower, upper = problem.parametrisation.bounds
    n = problem.n_parameters
    inside = x.copy()
    room = np.where(np.isfinite(upper - lower), 1e-6 * (upper - lower), 0.0)
    inside[:n] = np.clip(x[:n], lower + room, upper - room)
    inside[:n] = problem.parametrisation.put_in_order(inside[:n], margin=1e-3)
    return inside
