"""Multistart fit: `Simulator`, `Run`s and `FitOptions` in, `Fit` out.

1. Draw starts around the first guess (`sobol_starts`).
2. Follow every start to a minimum (`descend_from`), until enough starts share the best one.
3. Group the minima into basins and take the best.
4. Compute covariance, statuses, identifiable combinations, scores, outcome and warnings at the best minimum.

The command, the posterior and the search for missing effects call `fit`; it knows a model only as a `Simulator`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.optimise.basins import sort_into_basins
from haptid.identification.optimise.homotopy import descend
from haptid.identification.optimise.levenberg_marquardt import Descent
from haptid.identification.optimise.starts import sobol_starts
from haptid.identification.optimise.workers import Here, Processes, Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Basin, Fit, RunScore
from haptid.identification.result.outcome import NoStartError, outcome_of, with_cause
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.covariance import Curvature, curvature
from haptid.identification.statistics.excitation_warnings import excitation_warnings
from haptid.identification.statistics.identifiability import combinations, felt_sizes, statuses
from haptid.identification.statistics.profile_likelihood import profiles
from haptid.identification.statistics.score import score, score_of
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import profile_out
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
    minima = find_minima(problem, workers)
    return _result(problem, runs, minima.best, minima.basins, minima.descents, begun)


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


def find_minima(problem: Problem, workers: Workers, report: Callable[[int], None] = lambda _: None) -> Minima:
    """Follow starts around the first guess to their minima, until enough of them share the best one.

    Parameters
    ----------
    problem
        Problem to minimise.
    workers
        Workers that run the starts.
    report
        Called with the number of starts that are done, before each further one.

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
        report(len(done))
        return _more(problem, done)

    descents = workers.until(descend_from, [(problem, theta) for theta in starts], more)
    basins = sort_into_basins(problem, descents)
    if not basins:
        files = ", ".join(run.file for run in problem.runs)
        msg = f"no start gave a finite simulation of {files}; check units, bounds and first guesses"
        raise NoStartError(msg)
    return Minima(descents=tuple(descents), basins=basins)


def descend_from(problem: Problem, theta: Array) -> Descent:
    """Follow one start to a minimum; a worker runs it.

    Parameters
    ----------
    problem
        Problem to minimise.
    theta
        Parameters of the start, shape (n_p,); the initial states start at the first samples.

    Returns
    -------
    Descent
    """
    return descend(problem, problem.first(theta))


def _more(problem: Problem, done: Sequence[Descent]) -> int:
    """Return how many more starts are needed at least until enough of them share the best minimum."""
    options = problem.options
    basins = sort_into_basins(problem, done)
    if not basins:
        return 1
    # Above the noise the residual cannot confirm that a minimum is the best: more starts must agree on it.
    quiet = basins[0].over_noise <= options.tolerance
    return max((options.agree if quiet else THRESHOLDS.agreeing_starts_above_noise) - len(basins[0].starts), 0)


def _result(
    problem: Problem,
    runs: tuple[Run, ...],
    best: Descent,
    basins: tuple[Basin, ...],
    descents: Sequence[Descent],
    begun: float,
) -> Fit:
    n, parametrisation, s = problem.n_parameters, problem.parametrisation, best.x[: problem.n_parameters]
    theta, bent = problem.theta(best.x), curvature(problem, best.x)
    slope = parametrisation.slope(theta)
    # Divided by the residual's excess over the noise and by its correlation time, as `Fit.information` promises.
    data = profile_out(bent.data, range(n)) / (max(best.cost / problem.weight, 1.0) * max(bent.correlation_time, 1.0))
    felt = felt_sizes(parametrisation, problem.runs)
    status = statuses(parametrisation, s, np.sqrt(np.diag(bent.covariance)[:n]), felt)
    x0 = {run.file: x for run, x in zip(problem.runs, problem.x0(best.x), strict=True)}
    fitted = {run.file: problem.simulator.simulate(theta, run, x0=x0[run.file]).y for run in problem.runs}
    scores = _scores(problem, theta, runs, x0, fitted)
    outcome = outcome_of(
        len(basins[0].starts),
        basins[0].over_noise,
        problem.options.tolerance,
        unseen=max((score.over_noise for score in scores if score.use == "validate"), default=0.0),
        rows=sum(run.y.size for run in problem.runs),
        parameters=n,
    )
    excited = any(np.any(np.ptp(run.u, axis=0) > 0) for run in problem.runs)
    outcome = with_cause(outcome, over_motion=_over_motion(problem.runs, scores), excited=excited)
    return Fit(
        equations=parametrisation.equations,
        theta=theta,
        free=parametrisation.ids,
        covariance=_physical(bent, n, slope),
        information=data / np.outer(slope, slope),
        cost=best.cost / problem.weight,
        outcome=outcome,
        basins=basins,
        starts=len(descents),
        x0=x0,
        sigma={run.file: run.sensor_std for run in problem.runs},
        correlation_time=bent.correlation_time,
        simulations=sum(d.calls for d in descents) * len(problem.runs),
        wall_s=time.perf_counter() - begun,
        statuses=status,
        combinations=combinations(parametrisation, s, data, status, felt),
        warnings=excitation_warnings(
            parametrisation.equations, theta, [(run.t, fitted[run.file]) for run in problem.runs]
        ),
        runs=scores,
        notes=tuple(dict.fromkeys(note for run in runs if run.use != "excluded" for note in run.notes)),
        profiles=profiles(problem, best.x, bent) if problem.options.profile else {},
    )


def _over_motion(runs: Sequence[Run], scores: Sequence[RunScore]) -> float:
    """Return the RMS of the residual over that of the motion about its mean, the largest of the joints."""
    fitted = {score.file: score for score in scores if score.use == "fit"}
    residual = np.mean([fitted[run.file].rmse ** 2 for run in runs], axis=0)
    motion = np.mean([np.var(run.y, axis=0) for run in runs], axis=0)
    return float(np.sqrt(np.max(residual / np.maximum(motion, np.finfo(float).tiny))))


def _physical(bent: Curvature, n: int, slope: Array) -> Array:
    return np.asarray(bent.covariance[:n, :n] * np.outer(slope, slope))


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
