"""Which rows of a run are fitted: number of rows in, mask out."""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.slow_rows import Mask


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
