"""``python -m measurement.check [CAMPAIGN]``: read a campaign and say what is in it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.checks.summary import row_json, summarise, table_text
from haptid.measurement.commands import check as main
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.command import progress


def check_campaign(campaign: Path | None, quiet: bool) -> dict[str, Any]:
    """Read a campaign, and tell what is in it.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    quiet
        Whether no progress is shown.

    Returns
    -------
    dict
        Facts of the campaign and of every joint of every run, and what was remarked.
    """
    with warnings_on_stderr():
        found = read_campaign(campaign)
        prepare_campaign(found)
    click.echo(f"{found.title}\n{_counts(found)}\n")
    bar: Any = progress(total=len(found.runs), title="check", quiet=quiet or not sys.stderr.isatty())
    with bar:
        rows = summarise(found, report=bar.update)
    click.echo(table_text(rows))
    head = {"title": found.title, "device": found.device, "measured": found.measured, "hold": found.hold}
    return {**head, "configurations": [list(joints) for joints in found.configurations], "runs": [*map(row_json, rows)]}


def _counts(campaign: Campaign) -> str:
    by_use = [f"{sum(run.use == use for run in campaign.runs)} {use}" for use in ("fit", "validate", "excluded")]
    kinds = "; ".join("+".join(map(str, joints)) for joints in campaign.configurations)
    lacking = [j for j in campaign.configurations if campaign.runs_of(j, "fit") and not campaign.runs_of(j, "validate")]
    names = "; ".join("+".join(map(str, joints)) for joints in lacking)
    note = f"\nno validation run for {names}: the last third of the longest run will be held out" if lacking else ""
    return (
        f"device {campaign.device}, {campaign.label} data, torque between rows: {campaign.hold}, "
        f"{len(campaign.runs)} runs ({', '.join(by_use)}), free joints {kinds}{note}"
    )


if __name__ == "__main__":
    main()
