"""``python -m measurement.check [CAMPAIGN]``: read a campaign and say what is in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.checks.recorded_torque import with_torques_that_were
from haptid.measurement.checks.summary import row_json, summarise, tell_table
from haptid.measurement.commands import check as main
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.format.reading import is_foreign, read_campaign
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.numbers import count_of
from haptid.support.terminal import Count, show


def check_campaign(campaign: Path | None, quiet: bool, model: Path | None, limit_s: float) -> dict[str, Any]:
    """Read a campaign, and tell what is in it.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    quiet
        Whether no progress is shown.
    model
        FMU that the campaign is about; None where there is none, or where the campaign names it.
    limit_s
        Longest wait for one simulation of an FMU [s].

    Returns
    -------
    dict
        Facts of the campaign and of every joint of every run, and what was remarked.

    Raises
    ------
    InputError
        At the first fault of the campaign.
    """
    if campaign is not None and (model is not None or is_foreign(campaign)):
        return _check_foreign(campaign, model, limit_s)
    with warnings_on_stderr():
        found = read_campaign(campaign)
        prepare_campaign(found)
    click.echo(f"{found.title}\n{_counts(found)}\n")
    with Count[None](total=len(found.runs), title="check", quiet=quiet) as bar:
        rows = summarise(found, report=bar.update)
    remarks = with_torques_that_were(found).remarks
    show(tell_table(rows, remarks))
    head = {"title": found.title, "device": found.device, "measured": found.measured, "hold": found.hold}
    return {
        **head,
        "remarks": list(remarks),
        "configurations": [list(joints) for joints in found.configurations],
        "runs": [*map(row_json, rows)],
    }


def _check_foreign(folder: Path, model: Path | None, limit_s: float) -> dict[str, Any]:
    """Check a campaign about an FMU as `identification.run` will, tell what is in it, and return that."""
    # A command may ask the room that will use the campaign; other campaigns do without these imports.
    from haptid.identification.calibration.calibrate import simulator_of, try_all_runs  # noqa: PLC0415
    from haptid.identification.calibration.words import tell_check  # noqa: PLC0415
    from haptid.identification.foreign.process import ForeignFmu  # noqa: PLC0415

    with warnings_on_stderr():
        found = read_foreign_campaign(folder, model)
    with ForeignFmu(found.model, limit_s=limit_s) as fmu:
        simulator = simulator_of(found, fmu)
        try_all_runs(found, simulator)
        show(tell_check(found, simulator))
    runs = [{"file": run.file, "use": run.use, "rows": int(run.t.size)} for run in found.runs]
    return {
        "title": found.title,
        "model": str(found.model),
        "measured": found.measured,
        "inputs": list(found.inputs),
        "outputs": list(found.outputs),
        "parameters": [q.structured for q in simulator.equations.parameters],
        "runs": runs,
    }


def _counts(campaign: Campaign) -> str:
    by_use = [f"{sum(run.use == use for run in campaign.runs)} {use}" for use in ("fit", "validate", "excluded")]
    kinds = "; ".join("+".join(map(str, joints)) for joints in campaign.configurations)
    lacking = [j for j in campaign.configurations if campaign.runs_of(j, "fit") and not campaign.runs_of(j, "validate")]
    names = "; ".join("+".join(map(str, joints)) for joints in lacking)
    note = f"\nno validation run for {names}: the last third of the longest run will be held out" if lacking else ""
    return (
        f"device {campaign.device}, {campaign.label} data, torque between rows: {campaign.hold}, "
        f"{count_of(len(campaign.runs), 'run')} ({', '.join(by_use)}), free joints {kinds}{note}"
    )


if __name__ == "__main__":
    main()
