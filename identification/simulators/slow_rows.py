"""Rows of a measured motion at rest or near a reversal: speed and width of the filter in, masks out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from haptid.identification.simulators.inverse_dynamics import SPEED, WIDTH
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.thresholds import THRESHOLDS as MEASUREMENT
from haptid.measurement.values.run import Array, Run

Mask = NDArray[np.bool_]


def at_rest(speed: Array, width: float) -> Mask:
    """Return which rows are at rest, or so near a rest that the filter mixes its torque in.

    A reversal passes through speed 0 as well, but not for as long as the filter reaches. The torque of a resting joint
    is whatever friction happens to hold there; the first and the last rows of a motion are filtered together with it.

    Parameters
    ----------
    speed
        Filtered speed of one joint [rad/s], shape (n_t,).
    width
        Standard deviation of the filter [rows].

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True in stretches of low speed that are longer than twice the filter's reach, and up to
        `THRESHOLDS.step_of_friction_in_filter_widths` from them.
    """
    reach = MEASUREMENT.filter_reach_in_widths * width
    slow = _slow(speed)
    rest = np.zeros(slow.size, dtype=bool)
    for part in np.split(np.arange(slow.size), np.flatnonzero(np.diff(slow)) + 1):
        rest[part] = slow[part[0]] and part.size > 2.0 * reach
    return _widen(rest, width)


def near_reversal(speed: Array, width: float) -> Mask:
    """Return which rows are so near a reversal that the filter decides their friction.

    Dry friction steps where the speed changes its sign. The filtered speed does so earlier or later than the joint, by
    a part of the filter's width, always to the same side where the acceleration changes there; and a joint may stick
    in between for less than the filter resolves. What is left there looks like a lag.

    Parameters
    ----------
    speed
        Filtered speed of one joint [rad/s], shape (n_t,).
    width
        Standard deviation of the filter [rows].

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True in stretches of low speed, at changes of its sign, and
        `THRESHOLDS.step_of_friction_in_filter_widths` from them.
    """
    turn = _slow(speed)
    turn[1:] |= np.signbit(speed[1:]) != np.signbit(speed[:-1])
    return _widen(turn, width)


def rests(run: Run) -> Mask:
    """Return which rows of a `torque_run` are at rest, as `at_rest`.

    Parameters
    ----------
    run
        Run with filtered speed and width of the filter in ``extra``.

    Returns
    -------
    ndarray of bool, shape (n_t,)
    """
    return at_rest(run.extra[SPEED], float(run.extra[WIDTH][0]))


def turns(run: Run) -> Mask:
    """Return which rows of a `torque_run` are near a reversal, as `near_reversal`.

    Parameters
    ----------
    run
        Run with filtered speed and width of the filter in ``extra``.

    Returns
    -------
    ndarray of bool, shape (n_t,)
    """
    return near_reversal(run.extra[SPEED], float(run.extra[WIDTH][0]))


def _slow(speed: Array) -> Mask:
    limit = THRESHOLDS.largest_rest_speed_over_rms_speed * np.sqrt(np.mean(speed**2))
    return np.asarray(np.abs(speed) < limit)


def _widen(rows: Mask, width: float) -> Mask:
    """Return also the rows to which the filter spreads a step of friction at the rows of a mask."""
    reach = max(THRESHOLDS.step_of_friction_in_filter_widths * width, THRESHOLDS.least_rows_of_step)
    return np.asarray(binary_dilation(rows, iterations=round(reach)))
