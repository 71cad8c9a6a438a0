"""Hold out the last third of the longest run where a configuration has no validation run."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run

SHARE = 2.0 / 3.0
LEAST_ROWS = 24


def hold_out(run: Run) -> tuple[Run, Run]:
    """Split a run in time: the first two thirds to fit, the last third to judge.

    The part to judge is the whole run, simulated from its start and scored from ``score_from`` on, so that the friction
    state at the cut need not be guessed.

    Returns
    -------
    fit, validate
        Both under the run's own file name, each with a note.
    """
    cut = int(np.searchsorted(run.t, SHARE * run.t[-1]))
    note = f"no validation run: {run.file} is fitted up to {run.t[cut - 1]:.3g} s, its last third was held out"
    fit = run.but(
        t=run.t[:cut],
        u=run.u[:cut],
        y=run.y[:cut],
        v=None if run.v is None else run.v[:cut],
        extra={name: column[:cut] for name, column in run.extra.items()},
        notes=(*run.notes, note),
    )
    return fit, run.but(use="validate", score_from=cut, notes=(*run.notes, note))


def with_validation(campaign: Campaign) -> Campaign:
    """Return the campaign with a held-out run for every fitted configuration that has no validation run.

    A configuration whose longest run has fewer than 24 rows is left as it is, with a note in that run.
    """
    runs = list(campaign.runs)
    for joints in campaign.configurations:
        fits = campaign.runs_of(joints, "fit")
        if not fits or campaign.runs_of(joints, "validate"):
            continue
        longest = max(fits, key=lambda run: float(run.t[-1]))
        index = next(i for i, run in enumerate(runs) if run is longest)
        runs[index : index + 1] = _parts(longest)
    return campaign.but(runs=tuple(runs))


def _parts(run: Run) -> list[Run]:
    if run.t.size < LEAST_ROWS:
        note = f"no validation run, and {run.file} is too short ({run.t.size} rows) to hold a part of it out"
        return [run.but(notes=(*run.notes, note))]
    return list(hold_out(run))
