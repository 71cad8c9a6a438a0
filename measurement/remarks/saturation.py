"""Look for a torque that rests at its largest value, as of a limited command or a saturated amplifier: `Run` in.

A torque that was designed may rest there, too, as a square wave or a staircase does: it rests elsewhere as well, or is
hardly anywhere else. A controller, whose reference was recorded, designs none. The peak of a smooth torque in coarse
numbers rests for as long as it takes through the next few numbers below it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run

STEPS_BELOW = 3
"""Steps of the numbers below the end in which a smooth peak is for as long as within a step of it."""


def find_saturation(run: Run, column: int) -> str:
    """Return a remark on a torque that rests at its largest value.

    Parameters
    ----------
    run
        As it was read, with the recorded torque.
    column
        Column of the joint among ``run.free_joints``.

    Returns
    -------
    str
        A sentence with what to do; empty where the torque rests nowhere, or elsewhere as long.
    """
    u = run.u[:, column]
    largest = float(np.abs(u).max())
    if np.ptp(u) == 0.0:
        return ""
    step = estimate_resolution(u)
    ends = {"highest": float(u.max()), "lowest": float(u.min())}
    at_end = {
        name: np.abs(u - end) <= 0.5 * step
        for name, end in ends.items()
        if abs(end) >= THRESHOLDS.least_limit_over_largest_torque * largest
    }
    rests = {name: rows for name, rows in at_end.items() if _is_flat(u, rows, abs(ends[name]), step)}
    share = sum(float(rows.mean()) for rows in rests.values())
    if share < THRESHOLDS.least_share_of_rows_at_largest_torque:
        return ""
    if _rests_elsewhere(u, rests, controlled=_is_controlled(run)):
        return ""
    what = "force" if run.prismatic[column] else "torque"
    return (
        f"the {what} rests at its {' and '.join(rests)} value: was the command limited, or the amplifier or a sensor "
        "saturated? What was recorded has to be what acted; else measure with less, or leave these runs out"
    )


def _is_flat(u: Array, at_end: NDArray[np.bool_], end: float, step: float) -> bool:
    """Return whether the torque is at an end for several rows in a row, and hardly just below it."""
    if max(_lengths(at_end)) < THRESHOLDS.least_rows_of_plateau:
        return False
    distance = end - np.abs(u)
    same_sign = np.sign(u) == np.sign(u[int(np.argmax(at_end))])
    below = same_sign & ~at_end & (distance <= (STEPS_BELOW + 0.5) * step)
    return bool(below.sum() <= THRESHOLDS.largest_rows_below_over_at_largest_torque * at_end.sum())


def _is_controlled(run: Run) -> bool:
    """Return whether the reference of a controller was recorded with the run."""
    return any(f"reference_{joint}_" in name for joint in run.free_joints for name in run.extra)


def _rests_elsewhere(u: Array, rests: dict[str, NDArray[np.bool_]], *, controlled: bool) -> bool:
    """Return whether the torque rests away from its ends and from 0, too, or by design is hardly anywhere else."""
    ends = np.logical_or.reduce([*rests.values()])
    between = ~ends & (u != 0.0)
    if between.mean() < THRESHOLDS.least_share_of_rows_between_limits:
        return not controlled
    held = np.zeros(u.size, dtype=bool)
    held[1:] = np.diff(u) == 0.0
    lengths = np.array(_lengths(held & between))
    long = lengths >= 0.5 * float(np.median(_lengths(ends)))
    return bool(lengths[long].sum() > THRESHOLDS.largest_share_at_rest_between_limits * between.sum())


def _lengths(rows: NDArray[np.bool_]) -> list[int]:
    """Return the lengths of the stretches of true rows; 0 alone where there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]]).astype(int)))
    return [int(end - begin) for begin, end in zip(edges[::2], edges[1::2], strict=True)] or [0]
