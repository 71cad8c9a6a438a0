"""Seal runs: the held-out runs of a study in, those that choose and those that take part in no choice out.

Held-out runs decide which candidates are accepted, so that their gap is the gap of a selection. Where there are enough
of them, the last ones are sealed: no search, criterion or verdict sees them, and their gap is told beside the other.
"""

from __future__ import annotations

from collections.abc import Sequence

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Run


def seal(held_out: Sequence[Run]) -> tuple[tuple[Run, ...], tuple[Run, ...]]:
    """Divide held-out runs into those that choose and sealed ones.

    Parameters
    ----------
    held_out
        Runs with ``use == "validate"``, in the order of the campaign.

    Returns
    -------
    choosing, sealed
        Nothing is sealed where there are fewer than `THRESHOLDS.study.least_held_out_runs_to_seal`.
    """
    runs = tuple(held_out)
    if len(runs) < THRESHOLDS.study.least_held_out_runs_to_seal:
        return runs, ()
    count = max(round(THRESHOLDS.study.sealed_share_of_held_out * len(runs)), 1)
    return runs[:-count], runs[-count:]
