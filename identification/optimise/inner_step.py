"""The inner step along the homotopy: as coarse as the data allow, judged by halving it.

On the way to the minimum the integration's error need only be small against the residual, ‖y_h − y_{h/2}‖ ≤ `SHARE`·‖r‖
in units of the noise: it then moves the minimum of a level less than the next level does. The polish at the end takes
the model's own inner step again, so that nothing of it is left in the result.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.protocol import Stepped, at_step
from haptid.measurement.values.run import Array
from haptid.model.kernel.generate import DEFAULT_STEP

SHARE = 0.1
"""Largest difference that halving the step may make, as a share of the residual."""


def at_inner_step(problem: Problem, step: float) -> Problem:
    """Return the problem with inner steps of at most ``step`` [s]."""
    return replace(problem, simulator=at_step(problem.simulator, step))


def steps_of(problem: Problem) -> tuple[float, ...]:
    """Return inner steps [s] to choose from, the coarsest first: from one per row down to the model's own."""
    longest = max(float(np.median(np.diff(run.t))) for run in problem.runs)
    halvings = max(int(np.ceil(np.log2(longest / DEFAULT_STEP))), 0)
    return tuple(DEFAULT_STEP * 2.0**k for k in range(halvings, -1, -1))


def coarsen(problem: Problem, x: Array, gain: float) -> Problem:
    """Return the problem at the coarsest inner step that x allows at this gain; as it is where there is no choice."""
    if not isinstance(problem.simulator, Stepped):
        return problem
    steps = steps_of(problem)
    residuals = _residuals(problem, steps, x, gain)
    now = next(residuals)
    for step, finer in zip(steps[:-1], residuals, strict=True):
        if np.linalg.norm(finer - now) <= SHARE * np.linalg.norm(finer):
            return at_inner_step(problem, step)
        now = finer
    return problem


def _residuals(problem: Problem, steps: tuple[float, ...], x: Array, gain: float) -> Iterator[Array]:
    for step in steps:
        yield at_inner_step(problem, step).blocks(x, gain, jacobian=False).residual
