"""Rows along the homotopy: `Problem` in, `Problem` with one row in the place of several out.

A recording at 1 kHz has many rows for each turn of the motion, and every simulation on the way to a minimum passes all
of them. On that way fewer do, as long as what they lose is small against the residual: ‖y_m − y‖ ≤
`THRESHOLDS.largest_inner_step_error_over_residual`·‖r‖ at the rows that are kept, as an inner step is chosen
(`identification.optimise.inner_step`). The polish at the end has every row.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.weights import time_weights
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.signals.merged_rows import can_be_merged, merge_rows
from haptid.measurement.values.run import Array


def with_fewer_rows(problem: Problem, x: Array, gain: float) -> Problem:
    """Merge rows of a long recording where the residual at x does not show it.

    Parameters
    ----------
    problem
        Problem with every row.
    x
        Unknowns, shape (n,).
    gain
        Observer gain L [1/s].

    Returns
    -------
    Problem
        The problem with about `THRESHOLDS.most_rows_of_homotopy` rows, or the most that meet the condition; unchanged
        where it has few, or where its runs cannot be merged. Its unknowns are the same.
    """
    every = sum(run.t.size for run in problem.runs) // THRESHOLDS.most_rows_of_homotopy
    if every < 2 or not all(can_be_merged(run) for run in problem.runs):
        return problem
    exact = problem.blocks(x, gain, jacobian=False).rows
    while every > 1:
        few = merge_problem(problem, every)
        kept = [r[::every] for r in exact]
        lost = [a - b for a, b in zip(few.blocks(x, gain, jacobian=False).rows, kept, strict=True)]
        allowed = THRESHOLDS.largest_inner_step_error_over_residual * np.linalg.norm(np.concatenate(kept))
        if np.linalg.norm(np.concatenate(lost)) <= allowed:
            return few
        every //= 2
    return problem


def merge_problem(problem: Problem, every: int) -> Problem:
    """Return the problem with one row in the place of several, in the same unknowns.

    Parameters
    ----------
    problem
        Problem with every row.
    every
        Number of rows that one stands for.

    Returns
    -------
    Problem
    """
    runs = tuple(merge_rows(run, every) for run in problem.runs)
    return replace(problem, runs=runs, roots=tuple(np.sqrt(time_weights(run, problem.options.weights)) for run in runs))
