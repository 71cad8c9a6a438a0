"""Minima of a calibration: `Problem` and workers in, `Minima` out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.identification.calibration.simulator import ForeignSimulator
from haptid.identification.fit.minima import Minima, descend_from, find_minima
from haptid.identification.optimise.basins import sort_into_basins
from haptid.identification.optimise.levenberg_marquardt import Descent, cost_of
from haptid.identification.problem.residuals import Problem
from haptid.identification.statistics.covariance import curvature
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Workers


def reach_minima(problem: Problem, workers: Workers) -> Minima:
    """Follow the starts to their minima; without free parameters the one minimum is the FMU as it is stated.

    Parameters
    ----------
    problem
        Problem to minimise.
    workers
        Workers that run the starts.

    Returns
    -------
    Minima
        Minima of all starts that ran, sorted into basins.

    Raises
    ------
    NoStartError
        Where no start gave a finite simulation.
    """
    if problem.n_parameters:
        return find_minima(problem, workers)
    x = np.zeros(0)
    only = Descent(x=x, cost=cost_of(problem.blocks(x, jacobian=False)), calls=1, converged=True)
    return Minima(descents=(only,), basins=sort_into_basins(problem, [only]))


def polish(problem: Problem, minima: Minima) -> Minima:
    """Descend once more from the best minimum, and search around it where events make the cost jump.

    This is no start of its own.

    Parameters
    ----------
    problem
        Problem whose difference steps were chosen at the best minimum.
    minima
        Minima that the starts reached.

    Returns
    -------
    Minima
        The same starts with the best minimum replaced where the descent went lower; unchanged without free parameters.
    """
    best = minima.best
    if not problem.n_parameters:
        return minima
    again = descend_from(problem, problem.theta(best.x), True)
    lower = again if again.cost < best.cost else best
    polished = replace(lower, calls=best.calls + again.calls)
    narrowest = THRESHOLDS.difference_steps_over_size[0]
    if isinstance(problem.simulator, ForeignSimulator) and max(problem.simulator.steps) > narrowest:
        polished = search_around(problem, polished)
    descents = tuple(polished if one is best else one for one in minima.descents)
    return Minima(descents=descents, basins=sort_into_basins(problem, descents))


def search_around(problem: Problem, start: Descent) -> Descent:
    """Search for a lower cost among points around a minimum, ever closer to the lowest.

    Slopes over wide steps lead near the minimum of a cost with jumps, but not into the lowest of its many small ones.

    Parameters
    ----------
    problem
        Problem whose difference steps were chosen at the minimum.
    start
        Minimum to begin at.

    Returns
    -------
    Descent
        The lowest point; ``start`` with more calls where none is lower.
    """
    covariance = curvature(problem, start.x).covariance
    lower, upper = problem.parametrisation.bounds
    spread = np.linalg.cholesky(covariance + np.diag(1e-12 * np.diag(covariance)))
    rng = np.random.default_rng([problem.options.seed, 23])
    best = start
    for reach in THRESHOLDS.reaches_of_search_in_std:
        drawn = rng.standard_normal((THRESHOLDS.points_of_search, start.x.size))
        points = np.clip(best.x + reach * drawn @ spread.T, lower, upper)
        costs = [cost_of(problem.blocks(x, jacobian=False)) for x in points]
        lowest = int(np.argmin(costs))
        calls = best.calls + len(costs)
        found = costs[lowest] < best.cost
        best = replace(best, x=points[lowest], cost=costs[lowest], calls=calls) if found else replace(best, calls=calls)
    return best
