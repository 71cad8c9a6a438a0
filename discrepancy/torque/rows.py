"""Which rows of a run are fitted, and which count at all: `Run` of measured motion in, masks out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
    """Return which rows of a turned run are at rest, shape (n_t,).

    A reversal passes through speed 0 as well, but not for as long as the filter reaches.

    Parameters
    ----------
    run
        Run with the measured motion as ``u``, and the width of its filter in ``extra``.

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True in stretches of low speed that are longer than twice the filter's reach.
    """
    v = measured_motion(run)[:, 1]
    slow = np.abs(v) < IDENTIFICATION.largest_rest_speed_over_rms_speed * np.sqrt(np.mean(v**2))
    least = 2.0 * MEASUREMENT.filter_reach_in_widths * float(run.extra[WIDTH][0])
    rest = np.zeros(v.size, dtype=bool)
    for part in np.split(np.arange(v.size), np.flatnonzero(np.diff(slow)) + 1):
        rest[part] = slow[part[0]] and part.size > least
    return rest
