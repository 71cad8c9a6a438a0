"""``python -m measurement.check [CAMPAIGN]``: read a campaign and say what is in it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from haptid.identification.foreign.options import limit_option
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.checks.summary import summarise, table_text
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.format.places import allow_outside_option
from haptid.measurement.format.reading import is_foreign, read_campaign
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.command import exit_codes, progress


@click.command()
@click.argument("campaign", required=False, type=click.Path(path_type=Path))
@allow_outside_option
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@click.option(
    "--model",
    type=click.Path(path_type=Path, dir_okay=False),
    default=None,
    metavar="ANY.fmu",
    help="FMU that CAMPAIGN is about; the one that campaign.toml names where left out.",
)
@limit_option
@exit_codes
def main(campaign: Path | None, quiet: bool, model: Path | None, limit_s: float) -> None:
    """Check a measurement CAMPAIGN (a folder with campaign.toml; the embedded Freedom 6S campaign without it).

    Prints one row per run and joint, and remarks; exit 0 where the campaign can be used, 2 with one line where not.
    "~" marks what was estimated from the data. Units: N m and rad (N and m for a joint that slides). A campaign about
    an FMU is checked against the FMU's variables, and every run is simulated once.
    """
    if campaign is not None and (model is not None or is_foreign(campaign)):
        click.echo(_check_foreign(campaign, model, limit_s))
        return
    with warnings_on_stderr():
        found = read_campaign(campaign)
        prepare_campaign(found)
    click.echo(f"{found.title}\n{_counts(found)}\n")
    bar: Any = progress(total=len(found.runs), title="check", quiet=quiet or not sys.stderr.isatty())
    with bar:
        rows = summarise(found, report=bar.update)
    click.echo(table_text(rows))


def _check_foreign(folder: Path, model: Path | None, limit_s: float) -> str:
    """Check a campaign about an FMU as `identification.run` will, and say what is in it."""
    # A command may ask the room that will use the campaign; other campaigns do without these imports.
    from haptid.identification.calibration.calibrate import simulator_of, try_all_runs  # noqa: PLC0415
    from haptid.identification.calibration.words import checked_text  # noqa: PLC0415
    from haptid.identification.foreign.process import ForeignFmu  # noqa: PLC0415

    with warnings_on_stderr():
        found = read_foreign_campaign(folder, model)
    with ForeignFmu(found.model, limit_s=limit_s) as fmu:
        simulator = simulator_of(found, fmu)
        try_all_runs(found, simulator)
        return checked_text(found, simulator)


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
