"""Starts followed to their minima: `Problem` and workers in, `Minima` out.

1. Draw starts around the first guess (`sobol_starts`).
2. Follow every start to a minimum (`descend_from`), until enough starts share the best one: every other start by short
   steps, as they find the minimum of a right model from more starts, and the rest by long ones, as these find other
   minima of a wrong one.
3. Group the minima into basins.
4. Polish the best one, where all are far above the noise and were compared on fewer rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.optimise.basins import sort_into_basins
from haptid.identification.optimise.homotopy import descend, is_far, polish
from haptid.identification.optimise.levenberg_marquardt import Descent
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Basin
from haptid.identification.result.outcome import NoStartError
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Tell, Workers, tell_nobody
from haptid.measurement.values.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Minima:
    """Minima that the starts of a fit reached.

    Parameters
    ----------
    descents
        Results of the starts that ran, in their order.
    basins
        Minima that they share, the best first.
    """

    descents: tuple[Descent, ...]
    basins: tuple[Basin, ...]

    @property
    def best(self) -> Descent:
        """Descent with the smallest cost."""
        return min(self.descents, key=lambda d: d.cost if np.isfinite(d.cost) else np.inf)


def find_minima(problem: Problem, workers: Workers) -> Minima:
    """Follow starts around the first guess to their minima, until enough of them share the best one.

    Parameters
    ----------
    problem
        Problem to minimise.
    workers
        Workers that run the starts.

    Returns
    -------
    Minima

    Raises
    ------
    NoStartError
        Where no start gave a finite simulation.
    """
    options = problem.options
    first = problem.parametrisation.initial if options.start is None else np.array(options.start)
    starts = sobol_starts(problem.parametrisation, first, options.starts, options.seed)

    def more(done: Sequence[Descent]) -> int:
        return _more(problem, done)

    descents = workers.until(
        descend_from, [(problem, theta, k % 2 == 0) for k, theta in enumerate(starts)], more, what="start"
    )
    basins = sort_into_basins(problem, descents)
    if not basins:
        files = ", ".join(run.file for run in problem.runs)
        msg = f"no start gave a finite simulation of {files}; check units, bounds and first guesses"
        raise NoStartError(msg)
    return _polished(problem, Minima(descents=tuple(descents), basins=basins))


def _polished(problem: Problem, minima: Minima) -> Minima:
    """Polish the best minimum on all rows, where it is so far above the noise that the starts were not."""
    best = minima.best
    if not is_far(problem, best):
        return minima
    polished = polish(problem, best)
    if not polished.cost < best.cost:
        return minima
    first, *others = minima.basins
    first = replace(
        first,
        over_noise=float(np.sqrt(polished.cost / problem.weight)),
        theta=problem.theta(polished.x),
        simulations=first.simulations + (polished.calls - best.calls) * len(problem.runs),
    )
    return Minima(
        descents=tuple(polished if descent is best else descent for descent in minima.descents),
        basins=(first, *others),
    )


def descend_from(problem: Problem, theta: Array, short: bool, tell: Tell = tell_nobody) -> Descent:
    """Follow one start to a minimum; a worker runs it.

    Parameters
    ----------
    problem
        Problem to minimise.
    theta
        Parameters of the start, shape (n_p,); the initial states start at the first samples.
    short
        Whether its steps are short (`descend`).
    tell
        Told how far the start is.

    Returns
    -------
    Descent
    """
    return descend(problem, problem.unknowns_at(theta), tell, short=short)


def _more(problem: Problem, done: Sequence[Descent]) -> int:
    """Return how many more starts are needed at least until enough of them share the best minimum."""
    options = problem.options
    basins = sort_into_basins(problem, done)
    if not basins:
        return options.agree
    # Above the noise the residual cannot confirm that a minimum is the best: more starts must agree on it.
    quiet = basins[0].over_noise <= options.tolerance
    return max((options.agree if quiet else THRESHOLDS.agreeing_starts_above_noise) - len(basins[0].starts), 0)
