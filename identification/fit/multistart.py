"""Multistart fit: `Simulator`, `Run`s and `FitOptions` in, `Fit` out.

1. Follow starts around the first guess to their minima (`identification.fit.minima`) and take the best.
2. Score all runs there.
3. Compute covariance, statuses, identifiable combinations, outcome and warnings (`fit_at`).

The command, the posterior and the search for missing effects call `fit`; it knows a model only as a `Simulator`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.fit.minima import Minima, find_minima
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit, RunScore
from haptid.identification.result.outcome import Outcome, is_like_fitted, outcome_of, outcome_of_starts, with_cause
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.covariance import Curvature, curvature
from haptid.identification.statistics.excitation_warnings import excitation_warnings
from haptid.identification.statistics.identifiability import combinations, felt_sizes, statuses
from haptid.identification.statistics.profile_likelihood import profiles
from haptid.identification.statistics.score import residual_over_motion, score, score_of
from haptid.identification.statistics.unseen import rms_beyond_left_open
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Here, Processes, Workers
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.quantity import Quantity
from haptid.support.linear_algebra import profile_out
from haptid.support.numbers import plain
from haptid.support.processes.threads import single_threaded


def fit(
    simulator: Simulator, runs: Sequence[Run], *, options: FitOptions | None = None, workers: Workers | None = None
) -> Fit:
    """Fit the free parameters of a simulator's equations to runs by multistart least squares.

    Parameters
    ----------
    simulator
        Model of the configuration.
    runs
        All runs of the configuration: those with ``use == "fit"`` are fitted, those with ``use == "validate"`` are only
        scored, and excluded ones are ignored.
    options
        Choices of the fit; the defaults where None.
    workers
        Workers that run the starts; as many processes as ``options.workers`` says where None.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        Where a fitted run has a joint without sensor noise and resolution.
    NumericalError
        Where no start gave a finite simulation.
    """
    options = options or FitOptions()
    if workers is not None:
        return single_threaded(_fit, simulator, tuple(runs), options, workers)
    if options.workers == 1:
        return single_threaded(_fit, simulator, tuple(runs), options, Here())
    with Processes(options.workers) as pool:
        return single_threaded(_fit, simulator, tuple(runs), options, pool)


def _fit(simulator: Simulator, runs: tuple[Run, ...], options: FitOptions, workers: Workers) -> Fit:
    begun = time.perf_counter()
    problem = Problem.of(simulator, tuple(run for run in runs if run.use == "fit"), options)
    return _result(problem, runs, find_minima(problem, workers), begun)


def _result(problem: Problem, runs: tuple[Run, ...], minima: Minima, begun: float) -> Fit:
    best = minima.best
    theta, bent = problem.theta(best.x), curvature(problem, best.x)
    x0 = {run.file: x for run, x in zip(problem.runs, problem.x0(best.x), strict=True)}
    fitted = {run.file: problem.simulator.simulate(theta, run, x0=x0[run.file]).y for run in problem.runs}
    scores = _scores(problem, theta, runs, x0, fitted)
    found = fit_at(problem, minima, bent, scores, felt_sizes(problem.parametrisation, problem.runs))
    if found.outcome is Outcome.UNSEEN:
        found = _beyond_left_open(problem, runs, found)
    excited, scaled = _excitation_of(problem)
    over_motion = residual_over_motion(problem.runs, scores)
    return found.but(
        outcome=with_cause(found.outcome, over_motion=over_motion, excited=excited, scaled=scaled),
        wall_s=time.perf_counter() - begun,
        warnings=(
            *found.warnings,
            *excitation_warnings(
                found.equations,
                theta,
                [(run.t, fitted[run.file]) for run in problem.runs],
                [id for id, status in found.statuses.items() if status == "identified"],
            ),
        ),
        notes=tuple(dict.fromkeys(note for run in runs if run.use != "excluded" for note in run.notes)),
        profiles=profiles(problem, best.x, bent) if problem.options.profile else {},
    )


def _beyond_left_open(problem: Problem, runs: Sequence[Run], found: Fit) -> Fit:
    """Judge the unseen runs by what neither their initial state nor the spread of the parameters explains."""
    by_file = {run.file: run for run in runs if run.use == "validate"}

    def ask(score: RunScore) -> RunScore:
        if score.use != "validate":
            return score
        beyond = rms_beyond_left_open(problem.simulator, found, by_file[score.file], score)
        return replace(score, beyond_open=beyond)

    scores = tuple(ask(score) for score in found.runs)
    unseen = max(score.unexplained for score in scores if score.use == "validate")
    if not is_like_fitted(unseen, problem.options.tolerance):
        return found
    told = [
        f"{score.file}: {plain(score.over_noise, 3)} times the noise, which its initial state (told by its first rows) "
        f"and the spread of the parameters explain but for {plain(score.unexplained, 3)}"
        for score in scores
        if score.use == "validate" and not is_like_fitted(score.over_noise, problem.options.tolerance)
    ]
    outcome = outcome_of_starts(len(found.basins[0].starts), quiet=True)
    return found.but(runs=scores, outcome=outcome, warnings=(*found.warnings, *told))


def fit_at(problem: Problem, minima: Minima, bent: Curvature | None, scores: Sequence[RunScore], felt: Array) -> Fit:
    """Compute covariance, statuses, combinations and outcome at the best minimum.

    Parameters
    ----------
    problem
        Problem that was minimised.
    minima
        Its minima.
    bent
        Curvature at the best of them; None where nothing was free.
    scores
        Scores of all runs.
    felt
        Sizes of the free parameters as `statistics.identifiability.felt_sizes` gives them, shape (n_free,).

    Returns
    -------
    Fit
        Without its duration, and with the simulations that the minimiser counts.
    """
    best, n, parametrisation = minima.best, problem.n_parameters, problem.parametrisation
    theta = problem.theta(best.x)
    outcome = outcome_of(
        len(minima.basins[0].starts),
        minima.basins[0].over_noise,
        problem.options.tolerance,
        unseen=max((score.over_noise for score in scores if score.use == "validate"), default=0.0),
        rows=sum(run.y.size for run in problem.runs),
        parameters=n,
    )
    found = Fit(
        equations=parametrisation.equations,
        theta=theta,
        free=parametrisation.ids,
        covariance=np.zeros((n, n)),
        information=np.zeros((n, n)),
        cost=best.cost / problem.weight,
        outcome=outcome,
        basins=minima.basins,
        starts=len(minima.descents),
        x0={run.file: x for run, x in zip(problem.runs, problem.x0(best.x), strict=True)},
        sigma={run.file: run.sensor_std for run in problem.runs},
        correlation_time=1.0,
        simulations=sum(d.calls for d in minima.descents) * len(problem.runs),
        wall_s=0.0,
        statuses={q.id: "fixed" for q in parametrisation.equations.parameters},
        combinations=(),
        runs=tuple(scores),
    )
    if bent is None:
        return found
    s, slope = best.x[:n], parametrisation.slope(theta)
    # Divided by the residual's excess over the noise and by its correlation time, as `Fit.information` promises.
    data = profile_out(bent.data, range(n)) / (max(best.cost / problem.weight, 1.0) * max(bent.correlation_time, 1.0))
    status = statuses(parametrisation, s, np.sqrt(np.diag(bent.covariance)[:n]), felt)
    return found.but(
        covariance=bent.covariance[:n, :n] * np.outer(slope, slope),
        information=data / np.outer(slope, slope),
        correlation_time=bent.correlation_time,
        statuses=status,
        combinations=combinations(parametrisation, s, data, status, felt),
    )


def with_agreement(found: Fit, starts: Fit, options: FitOptions) -> Fit:
    """Judge a fit that one start made by the agreement of the starts at whose best minimum it began.

    Parameters
    ----------
    found
        Fit from one start.
    starts
        Fit by several starts; ``found`` began at its estimates and stayed in their basin.
    options
        Choices of the fit.

    Returns
    -------
    Fit
        ``found`` with the basins and the number of starts of ``starts``, and the outcome that follows, where its
        outcome hangs on the agreement.
    """
    best = replace(found.basins[0], starts=starts.basins[0].starts)
    agreed = found.but(basins=(best, *starts.basins[1:]), starts=starts.starts)
    if found.outcome not in (Outcome.CONVERGED, Outcome.SINGLE_START, Outcome.ABOVE_NOISE, Outcome.LONELY):
        return agreed
    return agreed.but(outcome=outcome_of_starts(len(best.starts), quiet=best.over_noise <= options.tolerance))


def from_optimum(found: Fit, options: FitOptions, *, alone: bool = False) -> FitOptions:
    """Return the options of a fit that begins at the estimates of another.

    Parameters
    ----------
    found
        Fit at whose estimates the first start begins.
    options
        Choices of the fit.
    alone
        Whether this start is the only one, and descends at the last gain at once, from the initial states of the fit: a
        minimum needs no way to it.

    Returns
    -------
    FitOptions
        With `THRESHOLDS.starts_of_refit` starts at most.
    """
    start = tuple(float(x) for x in found.theta)
    if alone:
        states = {file: tuple(float(x) for x in x0) for file, x0 in found.x0.items()}
        return options.but(start=start, states=states, starts=1, gains=options.gains[-1:])
    return options.but(start=start, starts=min(options.starts, THRESHOLDS.starts_of_refit))


def _excitation_of(problem: Problem) -> tuple[bool, bool]:
    """Say whether the runs excite the parameters, and whether anything gives the torques their scale.

    Torques that change do both. So does a stated torque, mass or inertia in a free swing, whose torque is zero
    throughout.
    """
    equations = problem.parametrisation.equations
    changes = any(np.any(np.ptp(run.u, axis=0) > 0) for run in problem.runs)
    # Residuals of another kind have their torque in y.
    swings_freely = bool(equations.joints) and not any(np.any(run.u) for run in problem.runs)
    has_scale = any(_gives_scale(quantity) for quantity in equations.parameters)
    return changes or (swings_freely and has_scale), not swings_freely or has_scale


def _gives_scale(quantity: Quantity) -> bool:
    """Say whether what is stated of a parameter gives the torques of a free swing their scale."""
    if quantity.fixed:
        stated = quantity.initial
    elif quantity.prior is not None:
        stated = quantity.prior.mean
    else:
        return False
    # Torque, force, mass and inertia; a ratio or a time constant leaves the scale open.
    bears_force = "N" in quantity.unit or "kg" in quantity.unit
    return stated != 0.0 and bears_force


class _Theta:
    """Parameters alone, for `score`."""

    def __init__(self, theta: Array) -> None:
        self.theta = theta


def _scores(
    problem: Problem, theta: Array, runs: tuple[Run, ...], x0: dict[str, Array], fitted: dict[str, Array]
) -> tuple[RunScore, ...]:
    """Score all runs; ``fitted`` holds the simulated outputs of the fitted ones by file."""
    known, made = _Theta(theta), []
    for run in runs:
        if run.use == "fit":
            r = (run.y - fitted[run.file][:, : run.y.shape[1]])[run.scored]
            made.append(score_of(run, r, x0[run.file]))
        elif run.use == "validate":
            # The held-out part of a fitted file goes on from the initial state that the fit gave its fitted part.
            start = x0.get(run.file) if run.score_from else None
            made.append(score(problem.simulator, known, run, x0=start, free_velocity=problem.options.free_velocity))
    return tuple(made)
