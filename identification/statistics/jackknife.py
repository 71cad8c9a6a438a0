"""Jackknife of a fit with model discrepancy: `Fit` and runs in, `Fit` with wider standard deviations out.

A sandwich covariance takes the residual for noise. Where the residual is model discrepancy, the estimates depend on the
part of the motion that is fitted, and the delete-one-block jackknife shows how far (Künsch 1989; Efron & Tibshirani
1993, chapter 11):

    var s = (K − 1)/K·Σ_k (s_k − s̄)²,  s_k fitted without block k.

1. Cut every run into contiguous blocks and refit without each block.
2. Compute the jackknife's standard deviation, and the sandwich standard deviation of every refit.
3. Take the largest of these and of the fit's own, and judge the statuses again.

A parameter that a single block determines stays at its estimate when the refit leaves that block out, so that step 2
needs the sandwich of every refit too: a parameter is identified only where two parts of the motion determine it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.optimise.levenberg_marquardt import SumOfSquares, minimise
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.covariance import curvature
from haptid.identification.statistics.identifiability import combinations, felt_sizes, statuses
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.workers.workers import Here, Tell, Workers, tell_nobody
from haptid.measurement.values.run import Array, Run


def with_jackknife(
    simulator: Simulator, fit: Fit, runs: Sequence[Run], options: FitOptions, workers: Workers | None = None
) -> Fit:
    """Widen the standard deviations of a fit to the jackknife's, and judge the statuses by them.

    Parameters
    ----------
    simulator
        Simulator of the fit.
    fit
        Fit at its minimum.
    runs
        Runs of the fit; only those with ``use == "fit"`` count.
    options
        Options of the fit.
    workers
        Workers that run the refits; this process where None.

    Returns
    -------
    Fit
        The fit with covariance and information scaled by the growth of the standard deviations (the correlations stay),
        and with new statuses and combinations.

    Raises
    ------
    InputError
        Where a run has a joint without sensor noise and resolution.
    """
    problem = Problem.of(simulator, tuple(run for run in runs if run.use == "fit"), options)
    x = unknowns_of(problem, fit)
    parametrisation, n = problem.parametrisation, problem.n_parameters
    slope = parametrisation.slope(fit.theta)
    std = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0)) / slope
    wide = np.maximum(std, jackknife_std(problem, x, workers or Here())[:n])
    # Scaling by the growth keeps the correlations of the sandwich; a parameter without deviation stays without.
    grown = np.where(std > 0, wide / np.where(std > 0, std, 1.0), 1.0)
    felt = felt_sizes(parametrisation, problem.runs)
    judged = statuses(parametrisation, x[:n], wide, felt)
    # What was not identified with smaller standard deviations is not identified with larger ones.
    status = {id: "unidentifiable" if fit.statuses[id] == "unidentifiable" else now for id, now in judged.items()}
    return fit.but(
        covariance=fit.covariance * np.outer(grown, grown),
        information=fit.information / np.outer(grown, grown),
        statuses=status,
        combinations=combinations(
            parametrisation, x[:n], fit.information * np.outer(slope / grown, slope / grown), status, felt
        ),
    )


def jackknife_std(
    problem: Problem, x: Array, workers: Workers, blocks: int = THRESHOLDS.least_jackknife_blocks
) -> Array:
    """Compute the standard deviations of the unknowns by leaving out one block at a time.

    Parameters
    ----------
    problem
        Problem that was minimised.
    x
        Minimum, shape (n,).
    workers
        Workers that run the refits.
    blocks
        Smallest number of blocks of all runs together; every run has equally many.

    Returns
    -------
    ndarray, shape (n,)
        The larger of the jackknife's standard deviation and of the largest sandwich standard deviation of the refits,
        in scaled unknowns.
    """
    tasks = [(replace(problem, roots=roots), x) for roots in leave_out_blocks(problem.roots, blocks)]
    refits = workers.until(_refit, tasks, lambda done: len(tasks) - len(done), what="refit")
    s, widths = np.array([x for x, _ in refits]), np.array([std for _, std in refits])
    spread = np.sqrt((len(s) - 1) / len(s) * np.sum((s - s.mean(axis=0)) ** 2, axis=0))
    return np.asarray(np.maximum(spread, widths.max(axis=0)))


def _refit(problem: Problem, x: Array, tell: Tell = tell_nobody) -> tuple[Array, Array]:
    """Return the minimum near x and the standard deviations there."""
    most = THRESHOLDS.most_simulations_of_refit
    cost = SumOfSquares.of(problem)
    best = minimise(
        cost, x, iterations=most, tolerance=0.0, relative=1e-4, tell=lambda calls, _: tell(calls / most, "")
    ).x
    return best, np.sqrt(np.maximum(np.diag(curvature(problem, best).covariance), 0.0))


def leave_out_blocks(roots: Sequence[Array], blocks: int) -> list[tuple[Array, ...]]:
    """Set the weights of one block after the other to zero.

    Parameters
    ----------
    roots
        Roots √λ of the time weights by run, shape (n_t,) each.
    blocks
        Smallest number of blocks of all runs together.

    Returns
    -------
    list of tuple of ndarray
        The roots of all runs for every block, with 0 in the rows of that block.
    """
    # Rounded up: every run has equally many blocks, at least one.
    per_run = -(-blocks // len(roots))
    made = []
    for k, root in enumerate(roots):
        # From row 1: the first row is the prior of the run's initial position and stays in every refit.
        for rows in np.array_split(np.arange(1, root.size), per_run):
            cut = root.copy()
            cut[rows] = 0.0
            made.append((*roots[:k], cut, *roots[k + 1 :]))
    return made


def unknowns_of(problem: Problem, fit: Fit) -> Array:
    """Return the unknowns of a fit in a problem of the same runs.

    Parameters
    ----------
    problem
        Problem whose runs were fitted.
    fit
        Their fit.

    Returns
    -------
    ndarray, shape (n,)
        Scaled parameters, then the initial states of every run.
    """
    x = problem.unknowns_at(fit.theta)
    for run, start, part in zip(problem.runs, problem.starts, problem.slices(), strict=True):
        x[part] = start.delta_of(fit.x0[run.file])
    return x
