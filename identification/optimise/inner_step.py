"""Inner step of the integration along the homotopy: `Problem` in, `Problem` with a coarser inner step out.

On the way to the minimum the integration's error need only be small against the residual, ‖y_h − y‖ ≤
`THRESHOLDS.largest_inner_step_error_over_residual`·‖r‖ in units of the noise, with y and r at the model's own inner
step: it then moves the minimum of a level less than the next level does. The polish at the end uses that step again, so
that the result does not depend on the coarser one. Halving a step says less than the own one: where bristles are stiff,
neighbouring steps may agree far from it.

1. List inner steps from one per row down to the model's own, each half of the one before (`steps_of`).
2. Simulate at the own one, then from the coarsest on, and take the first that meets the condition (`coarsen`).

Bristles that settle within a few of the model's own steps need a finer one at the minimum itself: its error would be
called a lack of the model where the sensor is better than that. The same share decides, of the change by halving the
step; and of many rows an error may be small in each and still move the estimates by several standard deviations. The
step's error Δ moves them by ‖QᵀΔ‖ of these, with Q an orthonormal basis of the residual's Jacobian (`finer_step`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.protocol import Stepped, at_step
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.thresholds import THRESHOLDS as MODEL
from haptid.support.linear_algebra import orthonormal_basis


def at_inner_step(problem: Problem, step: float) -> Problem:
    """Return the problem with another inner step, where its simulator's inner step can be chosen.

    Parameters
    ----------
    problem
        Problem of a fit.
    step
        Longest inner step [s].

    Returns
    -------
    Problem
        The same problem with the simulator at that step.
    """
    return replace(problem, simulator=at_step(problem.simulator, step))


def steps_of(problem: Problem) -> tuple[float, ...]:
    """List the inner steps to choose from.

    Parameters
    ----------
    problem
        Problem whose runs give the time between rows.

    Returns
    -------
    tuple of float
        Inner steps [s], the coarsest first: from about one per row down to the model's own, by halves.
    """
    longest = max(float(np.median(np.diff(run.t))) for run in problem.runs)
    halvings = max(int(np.ceil(np.log2(longest / MODEL.inner_step_s))), 0)
    return tuple(MODEL.inner_step_s * 2.0**k for k in range(halvings, -1, -1))


def coarsen(problem: Problem, x: Array, gain: float) -> Problem:
    """Choose the coarsest inner step whose integration error is small against the residual at x.

    Parameters
    ----------
    problem
        Problem with the model's own inner step.
    x
        Unknowns, shape (n,).
    gain
        Observer gain L [1/s].

    Returns
    -------
    Problem
        The problem at that inner step; unchanged where the simulator's inner step cannot be chosen, or where no coarser
        one meets the condition.
    """
    if not isinstance(problem.simulator, Stepped):
        return problem
    *coarser, own = steps_of(problem)
    exact = _residual(problem, own, x, gain)
    allowed = THRESHOLDS.largest_inner_step_error_over_residual * np.linalg.norm(exact)
    for step in coarser:
        if np.linalg.norm(_residual(problem, step, x, gain) - exact) <= allowed:
            return at_inner_step(problem, step)
    return problem


def finer_step(problem: Problem, x: Array) -> float:
    """Choose the inner step of a result, whose integration error is small against the residual at its minimum.

    Parameters
    ----------
    problem
        Problem with the model's own inner step.
    x
        Unknowns at the minimum, shape (n,).

    Returns
    -------
    float
        The model's own inner step [s], or half of it, at most `THRESHOLDS.most_halvings_of_inner_step` times; the
        finest where the error moves the estimates with each. The own one where the simulator's inner step cannot be
        chosen, and where the error of none of these is small: a motion that hangs on small errors converges with no
        step.
    """
    own = MODEL.inner_step_s
    if not isinstance(problem.simulator, Stepped):
        return own
    gain = problem.options.gains[-1]
    blocks = at_inner_step(problem, own).blocks(x, gain)
    now, basis, chosen = blocks.residual, orthonormal_basis(blocks.jacobian), own
    # The finer and dearer steps are simulated only where the coarser ones are not close enough.
    for halvings in range(THRESHOLDS.most_halvings_of_inner_step + 1):
        finer = _residual(problem, own / 2.0 ** (halvings + 1), x, gain)
        if np.linalg.norm(finer - now) <= THRESHOLDS.largest_inner_step_error_over_residual * np.linalg.norm(finer):
            chosen = own / 2.0**halvings
            if _moves_little(finer - now, finer, basis):
                break
        now = finer
    return chosen


def _moves_little(error: Array, residual: Array, basis: Array) -> bool:
    """Say whether an error of the residual moves the estimates by a small part of their standard deviations."""
    # Where more than noise is left, these are wider by as much.
    wider = max(float(np.linalg.norm(residual)) / np.sqrt(residual.size), 1.0)
    return float(np.linalg.norm(basis.T @ error)) <= THRESHOLDS.largest_shift_by_inner_step * wider


def _residual(problem: Problem, step: float, x: Array, gain: float) -> Array:
    """Return the whitened residual at an inner step."""
    return at_inner_step(problem, step).blocks(x, gain, jacobian=False).residual
