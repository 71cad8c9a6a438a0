"""Find where a recorder lost rows: times in, whether rows are missing before each row out.

A gap is an interval far above the one that nearly all rows keep. Where rows come at irregular times by themselves, as
from a recorder that writes events, long intervals are usual and none of them is a gap.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def find_gaps(t: Array) -> NDArray[np.bool_]:
    """Find the rows before which a recorder lost others.

    Parameters
    ----------
    t
        Times [s], shape (n_t,).

    Returns
    -------
    ndarray of bool, shape (n_t,)
        True where the interval before a row is longer than `THRESHOLDS.longest_gap_in_run_rows` intervals of the length
        that `THRESHOLDS.share_of_usual_intervals` of them keep, and the rows after it do not make up for it. Nowhere
        where the times do not increase: a later check refuses them with their line.
    """
    missing = np.zeros(t.size, dtype=bool)
    intervals = np.diff(t)
    if intervals.size == 0 or not np.all(intervals > 0.0):  # negated, so that NaN counts as not increasing
        return missing
    usual = float(np.median(intervals))
    longest_usual = float(np.quantile(intervals, THRESHOLDS.share_of_usual_intervals, method="lower"))
    for before in np.flatnonzero(intervals > THRESHOLDS.longest_gap_in_run_rows * longest_usual):
        missing[before + 1] = not _is_made_up(t, int(before), usual)
    return missing


def _is_made_up(t: Array, before: int, usual: float) -> bool:
    """Whether the rows after a gap follow so fast that they take back half of it: they were late, and none is lost."""
    gap = t[before + 1] - t[before]
    last = min(before + round(gap / usual), t.size - 1)
    return bool(t[last] - t[before] <= (last - before) * usual + gap / 2.0)
