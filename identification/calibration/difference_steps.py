"""Steps of difference quotients: simulator, parameters and runs in, the simulator with a step for each parameter out.

The outputs of a model with events jump as a parameter moves an event over a solver's step. A quotient over a narrow
step misses the jumps, or divides one by a small number; a wide one averages them, but loses curvature. So the steps are
walked from the widest to the narrowest:

1. Find the widest step whose quotient agrees with that of the next wider one.
2. Go on to narrower steps while the agreement becomes better, as it does where the outputs are smooth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from haptid.identification.calibration.simulator import ForeignSimulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


def with_chosen_steps(simulator: ForeignSimulator, theta: Array, runs: Sequence[Run]) -> ForeignSimulator:
    """Choose the step of every free parameter's difference quotient.

    Parameters
    ----------
    simulator
        FMU whose steps are chosen.
    theta
        Parameters at which the quotients are compared, shape (n_p,).
    runs
        Fitted runs.

    Returns
    -------
    ForeignSimulator
        With one step over the parameter's size for each parameter, fixed ones included.
    """
    middles = [simulator.simulate(theta, run).y for run in runs]
    narrowest = THRESHOLDS.difference_steps_over_size[0]
    steps = [
        narrowest if quantity.fixed else _confirmed_step(simulator, theta, i, runs, middles)
        for i, quantity in enumerate(simulator.equations.parameters)
    ]
    return replace(simulator, steps=tuple(steps))


def _confirmed_step(
    simulator: ForeignSimulator, theta: Array, i: int, runs: Sequence[Run], middles: Sequence[Array]
) -> float:
    steps = THRESHOLDS.difference_steps_over_size
    quotients = [_quotients(simulator, theta, i, step, runs, middles) for step in steps]
    return steps[choose([_relative_change(narrow, wide) for narrow, wide in pairwise(quotients)])]


def choose(changes: Sequence[float]) -> int:
    """Choose a step by the changes of the quotient.

    Parameters
    ----------
    changes
        Change of the quotient from each step to the next wider one over the wider one's size [1], the narrowest first.

    Returns
    -------
    int
        Place of the step; that of the smallest change where none is at most `THRESHOLDS.largest_change_of_quotient`.
    """
    agreeing = [k for k, change in enumerate(changes) if change <= THRESHOLDS.largest_change_of_quotient]
    if not agreeing:
        return int(np.argmin(changes))
    place = agreeing[-1]
    while place and changes[place - 1] <= max(changes[place], THRESHOLDS.negligible_change_of_quotient):
        place -= 1
    return place


def _quotients(
    simulator: ForeignSimulator, theta: Array, i: int, step: float, runs: Sequence[Run], middles: Sequence[Array]
) -> Array:
    """Return the quotients of all runs in units of the noise, shape (n_rows,)."""
    parts = []
    for run, middle in zip(runs, middles, strict=True):
        quotient = simulator.quotient(theta, i, step, run, middle)
        parts.append((quotient / run.sensor_std).ravel())
    return np.concatenate(parts)


def _relative_change(narrow: Array, wide: Array) -> float:
    """Return the RMS of the change over the RMS of the wider quotient; infinite where one is not finite."""
    size = float(np.linalg.norm(wide))
    change = float(np.linalg.norm(wide - narrow))
    if not np.isfinite(change):
        return float("inf")
    return change / size if size > 0 else float(change > 0)
