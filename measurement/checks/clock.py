"""Check the clocks of a campaign: `Campaign` in and out, refused where rows are too close, too far apart or missing."""

from __future__ import annotations

import numpy as np

from haptid.measurement.tables.misnamed import likely_time_units
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.support.errors import InputError


def check_clocks(campaign: Campaign) -> Campaign:
    """Refuse a campaign where a simulation cannot follow the clock of a run.

    Parameters
    ----------
    campaign
        As it was read; excluded runs are not checked.

    Returns
    -------
    Campaign
        The same, unchanged.

    Raises
    ------
    InputError
        Where rows are less than 1e-9 s apart; where their median distance exceeds 0.5 s, as with time in milliseconds;
        or where a gap is longer than both 10 s and 100 rows: the motion in the gap is unknown, and a simulation across
        it would take hours.
    """
    for run in campaign.runs:
        if run.use != "excluded":
            _check(run, f"{campaign.folder / run.file}, time_s")
    return campaign


def _check(run: Run, where: str) -> None:
    gaps = np.diff(run.t)
    if gaps.min() < THRESHOLDS.shortest_row_interval_s:
        row, todo = int(np.argmin(gaps)), "check its unit, and take rows away that repeat a time"
        after = f"{where} after {run.t[row] + run.start_time:.6g} s"
        expected = f"time in seconds, with rows {THRESHOLDS.shortest_row_interval_s:g} s apart at least"
        raise InputError(after, expected=expected, got=f"{gaps[row]:.3g} s", todo=todo)
    usual, row = float(np.median(gaps)), int(np.argmax(gaps))
    if usual > THRESHOLDS.longest_row_interval_s:
        ways = [f"where the time is in {unit}, multiply it by {factor}" for unit, factor in likely_time_units(usual)]
        todo = "; ".join(ways)
        expected = f"time in seconds, with rows {THRESHOLDS.longest_row_interval_s} s apart at most"
        raise InputError(where, expected=expected, got=f"{usual:.4g} s", todo=todo)
    if gaps[row] > max(THRESHOLDS.longest_gap_s, THRESHOLDS.longest_gap_in_rows * usual):
        todo = "make two runs of what lies before and after"
        after = f"{where} after {run.t[row] + run.start_time:.6g} s"
        raise InputError(
            after, expected=f"no gap above {THRESHOLDS.longest_gap_s:g} s", got=f"{gaps[row]:.4g} s", todo=todo
        )
