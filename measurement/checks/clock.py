"""A clock that a joint can be simulated by: rows not too far apart, and no gap in which anything may have happened."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.support.errors import InputError

SLOWEST = 0.5
"""Usual time between rows [s] above which nothing of a joint's friction is left to see."""
LONGEST_GAP, MANY_ROWS = 10.0, 100.0
"""A gap may last this long [s], or as long as this many rows."""


def check_clocks(campaign: Campaign) -> Campaign:
    """Return the campaign, where the clocks of all its runs can be simulated by.

    Raises
    ------
    InputError
        Where rows are more than 0.5 s apart, as where the time is in milliseconds, or where a gap is longer than 10 s
        and than 100 rows: what the joint did meanwhile is not known, and a simulation across it would take hours.
    """
    for run in campaign.runs:
        if run.use != "excluded":
            _check(run)
    return campaign


def _check(run: Run) -> None:
    gaps = np.diff(run.t)
    usual, row = float(np.median(gaps)), int(np.argmax(gaps))
    if usual > SLOWEST:
        todo = "where the time is in ms, multiply it by 0.001"
        expected = f"time in seconds, with rows {SLOWEST} s apart at most"
        where = f"{run.file}, time_s"
        raise InputError(where, expected=expected, got=f"{usual:.4g} s", todo=todo)
    if gaps[row] > max(LONGEST_GAP, MANY_ROWS * usual):
        where = f"{run.file}, time_s after {run.t[row] + run.start_time:.6g} s"
        todo = "make two runs of what lies before and after"
        raise InputError(where, expected=f"no gap above {LONGEST_GAP:g} s", got=f"{gaps[row]:.4g} s", todo=todo)
