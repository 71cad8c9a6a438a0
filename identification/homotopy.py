"""Output-injection homotopy: refit with the observer gain lowered step by step to zero, then polish.

A free simulation of LuGre friction has false minima next to the true one. Pulled towards the measured position with
gain L [1/s], the simulation stays near the data, the cost has fewer minima, and the minimum moves continuously with L.
"""

from __future__ import annotations

import numpy as np

from identification.gauss_newton import Descent, gauss_newton
from identification.problem import Problem
from identification.slsqp import slsqp
from measurement.run import Array

LOOSE, FINAL = 1e-3, 1e-5
"""Relative decrease of the cost at which a level ends: above the last, and at it (the polish goes to 1e-10)."""
FEW, MANY = 15, 60
"""Most iterations of a level above the last, and of the last."""
LEAST_DAMPING = 1e-3


def descend(problem: Problem, x: Array) -> Descent:
    """Follow the minimum from the first gain to the last; the last level ends with a Gauss–Newton polish."""
    gains, calls = problem.options.gains, 0
    x = feasible(problem, x)
    for number in range(len(gains)):
        level = _level(problem, x, number)
        x, calls = level.x, calls + level.calls
    if problem.options.passive:
        return Descent(x=x, cost=level.cost, calls=calls, converged=level.converged)
    polish = gauss_newton(problem, x, gains[-1], iterations=MANY, damping=1e-9)
    return Descent(x=polish.x, cost=polish.cost, calls=calls + polish.calls, converged=polish.converged)


def _level(problem: Problem, x: Array, number: int) -> Descent:
    """Minimise at one gain. Steps are damped strongly at first, where parameters and data may lie far apart."""
    gains = problem.options.gains
    last = number == len(gains) - 1
    iterations, tolerance = (MANY, FINAL) if last else (FEW, LOOSE)
    if problem.options.method == "gauss_newton":
        return gauss_newton(problem, x, gains[number], iterations=iterations, tolerance=tolerance)
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
