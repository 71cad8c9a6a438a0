"""Which rows of a run are fitted, which count, and which name effects: `Run` of measured motion in, masks out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.inverse_dynamics import WIDTH, measured_motion
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.measurement.thresholds import THRESHOLDS as MEASUREMENT
from haptid.measurement.values.run import Run

Mask = NDArray[np.bool_]


def alternating(rows: int) -> Mask:
    """Return which rows are fitted, shape (rows,): all but those of every third stretch.

    Parameters
    ----------
    rows
        Number of rows of the run.

    Returns
    -------
    ndarray of bool, shape (rows,)
        True for a fitted row, False for a held-out one.
    """
    stretch = np.arange(rows) * THRESHOLDS.torque.stretches_per_run // rows
    last = THRESHOLDS.torque.stretches_per_held_out_one - 1
    return np.asarray(stretch % THRESHOLDS.torque.stretches_per_held_out_one != last)


def rests(run: Run) -> Mask:
    """Return which rows of a turned run are at rest, or so near a rest that the filter mixes its torque in.

    A reversal passes through speed 0 as well, but not for as long as the filter reaches. The torque of a resting joint
    is whatever friction happens to hold there; the first and the last rows of a motion are filtered together with it.

    Parameters
    ----------
    run
        Run with the measured motion as ``u``, and the width of its filter in ``extra``.

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True in stretches of low speed that are longer than twice the filter's reach, and up to
        `THRESHOLDS.torque.step_of_friction_in_filter_widths` from them.
    """
    reach = MEASUREMENT.filter_reach_in_widths * float(run.extra[WIDTH][0])
    slow = _slow(run)
    rest = np.zeros(slow.size, dtype=bool)
    for part in np.split(np.arange(slow.size), np.flatnonzero(np.diff(slow)) + 1):
        rest[part] = slow[part[0]] and part.size > 2.0 * reach
    return _widen(rest, run)


def turns(run: Run) -> Mask:
    """Return which rows of a turned run are so near a reversal that the filter decides its friction.

    Dry friction steps where the speed changes its sign. The filtered speed does so earlier or later than the joint, by
    a part of the filter's width, always to the same side where the acceleration changes there; and a joint may stick
    in between for less than the filter resolves. What is left there looks like a lag.

    Parameters
    ----------
    run
        Run with the measured motion as ``u``, and the width of its filter in ``extra``.

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True in stretches of low speed, at changes of its sign, and
        `THRESHOLDS.torque.step_of_friction_in_filter_widths` from them.
    """
    v = measured_motion(run)[:, 1]
    turn = _slow(run)
    turn[1:] |= np.signbit(v[1:]) != np.signbit(v[:-1])
    return _widen(turn, run)


def _slow(run: Run) -> Mask:
    v = measured_motion(run)[:, 1]
    return np.asarray(np.abs(v) < IDENTIFICATION.largest_rest_speed_over_rms_speed * np.sqrt(np.mean(v**2)))


def _widen(rows: Mask, run: Run) -> Mask:
    """Return also the rows to which the filter spreads a step of friction at the rows of a mask."""
    limits = THRESHOLDS.torque
    reach = max(limits.step_of_friction_in_filter_widths * float(run.extra[WIDTH][0]), limits.least_rows_of_step)
    return np.asarray(binary_dilation(rows, iterations=round(reach)))
