"""Fit the nominal model from several starts: `Study` in, `NominalFit` out.

1. Begin with the fit of the identification, where it was made of the same runs.
2. Where its own starts did not agree, or there is none, lay out starts by a Sobol sequence.
3. Fit from each start by homotopy, `starts_that_agree` starts side by side.
4. Stop when `starts_that_agree` starts share the best minimum, so that a stuck optimiser does not pass for missing
   physics.
5. Where the motion needs a far finer inner step than the starts had, or presliding is stiffer than the range that
   haptid chose, fit again (`at_own_step`, `with_stiffer_presliding`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.fit.homotopy import lay_out_under_observer, through_homotopy
from haptid.discrepancy.fit.solution import Solution, solve, start_vector
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.measurement.values.run import Array
from haptid.model.friction.registry import law_named
from haptid.noise.correlation import Noise
from haptid.support.errors import NumericalError
from haptid.support.listener import Progress, ignore_progress
from haptid.support.processes.threads import map_threads


@dataclass(frozen=True, slots=True, kw_only=True)
class NominalFit:
    """Fit of the nominal model with the record of its starts.

    Parameters
    ----------
    solution
        Best minimum.
    costs
        ‖r‖² of every start that stayed finite, in the order of the starts.
    reached
        Number of starts that reached the best minimum.
    calls
        Number of simulations of all runs.
    """

    solution: Solution
    costs: tuple[float, ...]
    reached: int
    calls: int


def agreeing(costs: Sequence[float], rows: int) -> int:
    """Count the costs that belong to the best minimum.

    Parameters
    ----------
    costs
        ‖r‖² of the starts.
    rows
        Number of scored residuals, the cost that noise alone is expected to leave.

    Returns
    -------
    int
        Number of costs within `equal_minima_chi2` of the least one, or within the share `equal_minima_excess_share` of
        its excess over ``rows``.
    """
    best = min(costs, default=np.inf)
    room = max(THRESHOLDS.fit.equal_minima_chi2, THRESHOLDS.fit.equal_minima_excess_share * (best - rows))
    return sum(cost <= best + room for cost in costs)


def fit_nominal(study: Study, *, starts: int = 8, seed: int = 0, tell: Progress = ignore_progress) -> NominalFit:
    """Fit the nominal model from several starts, under white noise.

    The fit of the identification, where there is one, is the first of them: it is refined at the study's inner step,
    bounds and noise, without the detour over the observer. As many starts agree on it as agreed there.

    Parameters
    ----------
    study
        Study with the fitted runs.
    starts
        Number of starts; fewer are used where `starts_that_agree` of them share the best minimum.
    seed
        Seed of the Sobol starts.
    tell
        Told of each start.

    Returns
    -------
    NominalFit
        Best minimum with the costs of all starts.

    Raises
    ------
    NumericalError
        If no start gives a finite simulation.
    """
    found: list[Solution] = []
    calls, agreed = 0, 0
    if study.carried is not None:
        refined = _refine(study, study.carried.values, [study.carried.x0[run.file] for run in study.fitted])
        calls = refined.calls
        if np.isfinite(refined.chi2):
            found, agreed = [refined], len(study.carried.basins[0].starts)
    if agreed >= THRESHOLDS.fit.starts_that_agree:
        # The starts of the identification that agreed on this minimum.
        return NominalFit(solution=found[0], costs=(found[0].chi2,) * agreed, reached=agreed, calls=calls)
    first = start_vector(study.base, {})
    parametrisation = lay_out_under_observer(study, ()).parametrisation
    most = THRESHOLDS.fit.starts_that_agree
    for done, (solution, used) in enumerate(_fits(study, sobol_starts(parametrisation, first, starts, seed)), start=1):
        tell("nominal fit", done, max(done, most), "starts" if done <= most else "starts, which do not agree yet")
        calls += used
        if np.isfinite(solution.chi2):
            found.append(solution)
        if _are_enough([s.chi2 for s in found], study.rows):
            break
    if not found:
        msg = f"{study.title}: no start gave a finite simulation; check units, bounds and first guesses"
        raise NumericalError(msg)
    costs = tuple(s.chi2 for s in found)
    best = min(found, key=lambda s: s.chi2)
    return NominalFit(solution=best, costs=costs, reached=agreeing(costs, study.rows), calls=calls)


def _are_enough(costs: Sequence[float], rows: int) -> bool:
    """Say whether the starts agree, or whether all leave so much that a model without its missing effect is stuck."""
    limits = THRESHOLDS.fit
    far = min(costs, default=0.0) > limits.least_energy_of_hopeless_starts * rows
    return agreeing(costs, rows) >= limits.starts_that_agree or (far and len(costs) >= limits.most_hopeless_starts)


def _fits(study: Study, starts: Sequence[Array]) -> Iterator[tuple[Solution, int]]:
    """Yield the fit from each start and its simulations, as many side by side as have to agree."""
    alone = replace(study, threads=1) if len(starts) > 1 else study

    def one(theta: Array) -> tuple[Solution, int]:
        named = {q.id: float(p) for q, p in zip(study.base.parameters, theta, strict=True)}
        return through_homotopy(alone, (), named)

    together = THRESHOLDS.fit.starts_that_agree
    for k in range(0, len(starts), together):
        yield from map_threads(one, starts[k : k + together], threads=study.threads)


def at_own_step(study: Study, base: NominalFit) -> NominalFit:
    """Fit the nominal model again, under white noise, at the inner step of a study.

    Parameters
    ----------
    study
        Study at the inner step that the motion needs.
    base
        Fit at another step.

    Returns
    -------
    NominalFit
        With the minimum at that step, and the costs of the starts as they were.
    """
    solution = _refine(study, base.solution.values, base.solution.x0)
    return replace(base, solution=solution, calls=base.calls + solution.calls)


def with_stiffer_presliding(study: Study, base: NominalFit) -> tuple[Study, NominalFit]:
    """Widen the range of the stiffness in presliding as long as the nominal model ends on it and leaves less beyond.

    That range is a guess from the travel where neither user nor device states it. A joint whose friction turns within
    less would show a discrepancy that is none of the joint's.

    Parameters
    ----------
    study
        Study with its nominal model.
    base
        Fit of the nominal model.

    Returns
    -------
    study, base
        Study with the range in which the fit was found, and the fit.
    """
    for _ in range(IDENTIFICATION.most_widenings_of_bounds):
        found, wider = base.solution, stiffer_study(study, base.solution)
        if wider is None:
            break
        again = _refine(wider, found.values, found.x0)
        if not again.chi2 < (1.0 - IDENTIFICATION.largest_relative_cost_difference_in_basin) * found.chi2:
            break
        study, base = wider, replace(base, solution=again, calls=base.calls + again.calls)
    return study, base


def stiffer_study(study: Study, found: Solution) -> Study | None:
    """Widen the range of the stiffness in presliding where a model ends on it.

    Parameters
    ----------
    study
        Study with its nominal model.
    found
        Optimum of the nominal model, or of one with effects.

    Returns
    -------
    Study or None
        None where the optimum lies within the range, or where user or device stated it.
    """
    stiffness = law_named(study.base.friction[0]).roles.stiffness
    if not study.alone or stiffness not in study.own:
        return None
    upper = study.base.parameter(stiffness).upper
    if found.values[stiffness] < THRESHOLDS.fit.on_upper_end_of_range * upper:
        return None
    ranges = {stiffness: {"upper": IDENTIFICATION.bounds_over_guess * upper}}
    return replace(study, base=study.base.with_parameters(ranges))


def _refine(study: Study, values: Mapping[str, float], x0: Sequence[Array]) -> Solution:
    """Fit the nominal model to the end from parameters by id and the initial states of a fit of the same runs."""
    iterations, tolerance = THRESHOLDS.fit.most_simulations_of_last_fit, THRESHOLDS.fit.nominal_tolerance_chi2
    return solve(study, (), Noise(), values, x0=x0, iterations=iterations, tolerance=tolerance)
