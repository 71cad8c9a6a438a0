"""Merge rows of long recordings: a `Study` in, the same study with one row in the place of several out.

A search costs as much as it has rows: signatures of the whole catalogue are kept for every reading. A device that is
recorded at 2 kHz says no more of its friction than at 400 Hz, as long as its torque hardly changes in between.

What is lost (`measurement.signals.merged_rows`) is found out by simulation: where it shows in the readings, fewer rows
are merged (`discrepancy.search.search`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.signals.merged_rows import can_be_merged, largest_change, merge_rows


def merged(study: Study, every: int) -> Study:
    """Return the study with one row in the place of ``every``.

    Parameters
    ----------
    study
        Study of one joint or several, with all its rows.
    every
        Number of rows that one stands for, at least 1.

    Returns
    -------
    Study
        The study as it is where ``every`` is 1.
    """
    if every == 1:
        return study
    fitted, unseen, sealed = (
        tuple(merge_rows(run, every) for run in runs) for runs in (study.fitted, study.unseen, study.sealed)
    )
    return replace(study, fitted=fitted, unseen=unseen, sealed=sealed, rows_merged=every)


def rows_to_merge(study: Study, most: int = THRESHOLDS.study.most_rows_searched) -> int:
    """Return how many rows may be merged into one, by the number of rows and by what the torque does between them.

    Parameters
    ----------
    study
        Study with all its rows.
    most
        Number of fitted rows that are few enough.

    Returns
    -------
    int
        1 where the fitted runs have at most ``most`` rows. Else as many as bring them there, but not more
        than lie within the inner step `coarse_step_s`, and not so many that the torque changes within them by more than
        `largest_torque_change_within_merged_rows`. 1 for runs whose input is not a torque, and for readings that the
        recorder averaged: a mean over other rows would not be what it averaged.
    """
    rows = sum(run.t.size - run.score_from for run in study.fitted)
    runs = (*study.fitted, *study.unseen, *study.sealed)
    if rows <= most or not all(map(can_be_merged, runs)):
        return 1
    spacing = max(float(np.median(np.diff(run.t))) for run in runs)
    longest = int(THRESHOLDS.study.coarse_step_s / spacing + 1e-6)
    every = min(-(-rows // most), longest)
    while every > 1 and largest_change(runs, every) > THRESHOLDS.study.largest_torque_change_within_merged_rows:
        every -= 1
    return max(every, 1)
