"""Output-injection homotopy: refit with the observer gain lowered step by step to zero, then polish.

A free simulation of LuGre friction has false minima next to the true one. Pulled towards the measured position with
gain L [1/s], the simulation stays near the data, the cost has fewer minima, and the minimum moves continuously with L.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.identification.optimise.inner_step import coarsen
from haptid.identification.optimise.levenberg_marquardt import Descent, minimise
from haptid.identification.optimise.slsqp import slsqp
from haptid.identification.problem.residuals import Problem
from haptid.measurement.values.run import Array

LOOSE, FINAL, POLISHED = 1e-3, 1e-5, 1e-8
"""Relative decrease of the cost at which a level ends: above the last, at it, and in the polish."""
FEW, MANY = 15, 60
"""Most iterations of a level above the last, and of the last."""
LEAST_DAMPING = 1e-3


def descend(problem: Problem, x: Array) -> Descent:
    """Follow the minimum from the first gain to the last; the last level ends with a Gauss–Newton polish.

    The levels run at a coarser inner step where that is close enough (`inner_step`), the polish at the model's own.
    """
    gains, calls = problem.options.gains, 0
    x = feasible(problem, x)
    coarse = problem
    for number, gain in enumerate(gains):
        if number in {0, len(gains) - 1}:
            coarse = coarsen(problem, x, gain)
        level = _level(coarse, x, number)
        x, calls = level.x, calls + level.calls
    if problem.options.passive:
        exact = slsqp(problem, x, gains[-1], iterations=MANY, tolerance=FINAL, damping=LEAST_DAMPING)
        return replace(exact, calls=calls + exact.calls)
    polish = minimise(problem, x, gains[-1], iterations=MANY, tolerance=0.0, relative=POLISHED, damping=1e-9)
    return replace(polish, calls=calls + polish.calls)


def _level(problem: Problem, x: Array, number: int) -> Descent:
    """Minimise at one gain. Steps are damped strongly at first, where parameters and data may lie far apart."""
    gains = problem.options.gains
    last = number == len(gains) - 1
    iterations, tolerance = (MANY, FINAL) if last else (FEW, LOOSE)
    if problem.options.method == "gauss_newton":
        return minimise(problem, x, gains[number], iterations=iterations, tolerance=0.0, relative=tolerance)
    damping = max(0.1**number, LEAST_DAMPING)
    return slsqp(problem, x, gains[number], iterations=iterations, tolerance=tolerance, damping=damping)


def feasible(problem: Problem, x: Array) -> Array:
    """Return x moved inside bounds and orderings, by a hair."""
    lower, upper = problem.scaling.bounds
    n = problem.n_parameters
    inside = x.copy()
    room = np.where(np.isfinite(upper - lower), 1e-6 * (upper - lower), 0.0)
    inside[:n] = np.clip(x[:n], lower + room, upper - room)
    order, limit = problem.scaling.orderings()
    for row, bound in zip(order, limit, strict=True):
        short = bound + 1e-3 - row @ inside[:n]
        if short > 0:
            inside[:n] += row * short / (row @ row)
    return inside
