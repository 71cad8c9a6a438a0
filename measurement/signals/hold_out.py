"""Hold out the last third of the longest run of a configuration without validation run: `Campaign` in and out."""

from __future__ import annotations

import numpy as np

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run


def hold_out(run: Run) -> tuple[Run, Run]:
    """Split a run in time: fit its first two thirds, validate on its last third.

    Parameters
    ----------
    run
        Run with at least two rows in its first two thirds.

    Returns
    -------
    fit, validate : Run
        Both have the run's file name and a note. ``validate`` holds all rows: it is simulated from the start and
        scored from ``score_from`` on, so that the friction state at the cut need not be guessed.
    """
    cut = int(np.searchsorted(run.t, THRESHOLDS.fitted_share_of_run * run.t[-1]))
    note = f"no validation run: {run.file} is fitted up to {run.t[cut - 1]:.3g} s, its last third was held out"
    fit = run.but(
        t=run.t[:cut],
        u=run.u[:cut],
        y=run.y[:cut],
        v=None if run.v is None else run.v[:cut],
        extra={name: column[:cut] for name, column in run.extra.items()},
        drive_inputs={name: column[:cut] for name, column in run.drive_inputs.items()},
        notes=(*run.notes, note),
    )
    return fit, run.but(use="validate", score_from=cut, notes=(*run.notes, note))


def with_validation(campaign: Campaign) -> Campaign:
    """Give every fitted configuration without a validation run a held-out one.

    Parameters
    ----------
    campaign
        Campaign whose noise is filled in.

    Returns
    -------
    Campaign
        The longest fit run of such a configuration is replaced by the two parts of `hold_out`. A run of fewer than
        24 rows is kept whole, with a note.
    """
    runs = list(campaign.runs)
    for joints in campaign.configurations:
        fits = campaign.runs_of(joints, "fit")
        if not fits or campaign.runs_of(joints, "validate"):
            continue
        longest = max(fits, key=lambda run: float(run.t[-1]))
        # By identity: runs do not compare by their content.
        index = next(i for i, run in enumerate(runs) if run is longest)
        runs[index : index + 1] = _parts(longest)
    return campaign.but(runs=tuple(runs))


def _parts(run: Run) -> list[Run]:
    if run.t.size < THRESHOLDS.least_rows_of_split_run:
        note = f"no validation run, and {run.file} is too short ({run.t.size} rows) to hold a part of it out"
        return [run.but(notes=(*run.notes, note))]
    return list(hold_out(run))
