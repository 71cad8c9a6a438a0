"""Error bars where the model misses something: refits that leave out one stretch of the data after the other.

A sandwich covariance takes what is left for noise. Where it is a systematic misfit, the estimates depend on which part
of the motion is looked at, and the delete-one-block jackknife shows how far (Künsch 1989; Efron & Tibshirani 1993,
chapter 11):

    var s = (K − 1)/K·Σ_k (s_k − s̄)²,  s_k fitted without block k.

A parameter that one block alone shows stays where it was when that block is left out. Each refit therefore brings its
own sandwich covariance, and the widest counts: what is known must show in two stretches of the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from haptid.identification.optimise.levenberg_marquardt import minimise
from haptid.identification.optimise.workers import Here, Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.covariance import curvature
from haptid.identification.statistics.identifiability import combinations, statuses
from haptid.measurement.values.run import Array, Run

BLOCKS = 6
ITERATIONS = 12


def with_jackknife(
    simulator: Simulator, fit: Fit, runs: Sequence[Run], options: FitOptions, workers: Workers | None = None
) -> Fit:
    """Return the fit with standard deviations no smaller than the jackknife's, and statuses judged by them.

    Parameters
    ----------
    simulator, runs, options
        Those of the fit; only the runs with ``use == "fit"`` count.
    workers
        Where the refits run; this process where None.
    """
    problem = Problem.of(simulator, tuple(run for run in runs if run.use == "fit"), options)
    x = _unknowns(problem, fit)
    scaling, n = problem.scaling, problem.n_parameters
    slope = scaling.slope(fit.theta)
    std = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0)) / slope
    wide = np.maximum(std, jackknife_std(problem, x, workers or Here())[:n])
    grown = np.where(std > 0, wide / np.where(std > 0, std, 1.0), 1.0)
    status = statuses(scaling, x[:n], wide)
    return fit.but(
        covariance=fit.covariance * np.outer(grown, grown),
        information=fit.information / np.outer(grown, grown),
        statuses=status,
        combinations=combinations(scaling, x[:n], fit.information * np.outer(slope / grown, slope / grown), status),
    )


def jackknife_std(problem: Problem, x: Array, workers: Workers, blocks: int = BLOCKS) -> Array:
    """Return standard deviations of the unknowns at the minimum x by leaving out one block at a time, shape (n,).

    Every run is cut into equally many contiguous blocks, at least ``blocks`` in all. The first row of a run stays: it
    is the prior of its start.
    """
    tasks = [(replace(problem, roots=roots), x) for roots in leave_out_blocks(problem.roots, blocks)]
    refits = workers.until(_refit, tasks, lambda done: len(tasks) - len(done))
    s, widths = np.array([x for x, _ in refits]), np.array([std for _, std in refits])
    spread = np.sqrt((len(s) - 1) / len(s) * np.sum((s - s.mean(axis=0)) ** 2, axis=0))
    return np.asarray(np.maximum(spread, widths.max(axis=0)))


def _refit(problem: Problem, x: Array) -> tuple[Array, Array]:
    """Return the minimum near x and the standard deviations there."""
    found = minimise(problem, x, iterations=ITERATIONS, tolerance=0.0, relative=1e-4).x
    return found, np.sqrt(np.maximum(np.diag(curvature(problem, found).covariance), 0.0))


def leave_out_blocks(roots: Sequence[Array], blocks: int) -> list[tuple[Array, ...]]:
    """Return the root weights of all runs once per block, with that block's rows at zero."""
    per_run = -(-blocks // len(roots))
    made = []
    for k, root in enumerate(roots):
        for rows in np.array_split(np.arange(1, root.size), per_run):
            cut = root.copy()
            cut[rows] = 0.0
            made.append((*roots[:k], cut, *roots[k + 1 :]))
    return made


def _unknowns(problem: Problem, fit: Fit) -> Array:
    x = problem.first(fit.theta)
    for run, start, part in zip(problem.runs, problem.starts, problem.slices(), strict=True):
        index = list(start.states)
        x[part] = (fit.x0[run.file][index] - start.base[index]) / start.unit
    return x
