"""``python -m discrepancy.run [CAMPAIGN] --joint J``: what is missing in the model of a joint, if anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from discrepancy.finding import Finding, as_json, find
from discrepancy.study import study_of
from discrepancy.torque_finding import find_torque, torque_json
from discrepancy.torque_study import torque_study_of
from fmu_build.build import Kind
from identification.strategy import choose_for
from measurement.campaign import Campaign
from measurement.prepare import campaign_for_command
from model.effect import Effect
from model.effects import with_folder
from report.discrepancy_page import discrepancy_page
from report.torque_gap_page import torque_gap_page
from support.command import common_options, exit_codes, parse_joints, progress
from support.errors import InputError
from support.files import write_json, write_text


@click.command()
@click.argument("campaign", required=False)
@common_options
@click.option("--joint", type=int, default=None, help="The joint to study; --joints studies several, neither all.")
@click.option(
    "--effects", type=click.Path(path_type=Path), default=None, help="Folder with effects of your own, one file each."
)
@click.option("--without", default="", metavar="ID,ID", help="Leave these entries out of the catalogue.")
@click.option("--starts", default=8, show_default=True, type=click.IntRange(min=1), help="Most starts of the base fit.")
@click.option("--fmu", "kind", type=click.Choice(["python", "native"]), default="python", show_default=True)
@exit_codes
def main(
    campaign: str | None,
    out: Path,
    joints: str | None,
    *,
    joint: int | None,
    effects: Path | None,
    without: str,
    **choices: Any,
) -> None:
    """Find what is missing in a joint's model, name it, add it and show the gap shrink.

    CAMPAIGN is a folder with campaign.toml; the embedded Freedom 6S one where left out.
    """
    left_out = {part for part in without.split(",") if part}
    entries = {key: e for key, e in with_folder(effects).items() if not {key, e.id} & left_out}
    if unknown := left_out - {name for key, e in with_folder(effects).items() for name in (key, e.id)}:
        raise InputError("--without", expected="ids of the catalogue", got=", ".join(sorted(unknown)))
    read = campaign_for_command(campaign)
    chosen = (joint,) if joint is not None else parse_joints(joints) or read.joints
    if not chosen:
        raise InputError("campaign.toml", expected="runs with one free joint", got="none")
    if choices["scheduler"]:
        click.echo("note: --scheduler is not used, the search runs here on --workers threads", err=True)
    swept = [j for j in chosen if choose_for(read.runs_of((j,))).kind == "torque"]
    for j in swept:
        _torque(read, j, entries, out, choices)
    studies = [study_of(read, j, entries, threads=choices["workers"]) for j in chosen if j not in swept]
    for study in studies:
        bar: Any = progress(total=None, title=f"joint {study.joint}", quiet=choices["quiet"])
        with bar:
            finding = find(study, out, **_options(choices), tell=bar.set_description)
        _written(finding, read, out, choices["seed"])


def _torque(read: Campaign, joint: int, entries: dict[str, Effect], out: Path, choices: dict[str, Any]) -> None:
    """Study a joint that a position controller swept: its torque is scored."""
    bar: Any = progress(total=None, title=f"joint {joint}", quiet=choices["quiet"])
    with bar:
        study = torque_study_of(read, joint)
        finding = find_torque(study, entries, out, **_options(choices), tell=bar.set_description)
    folder = out / "discrepancy"
    write_json(folder / f"joint{joint}.json", torque_json(finding, measured=read.measured, seed=choices["seed"]))
    write_text(folder / f"joint{joint}.html", torque_gap_page(finding, read.title, measured=read.measured))
    gap = finding.gaps["validate"]
    click.echo(f"joint {joint}: {finding.verdict}. {finding.sentence}")
    click.echo(
        f"  held-out torque: RMS {gap.before:.3g} N m before, {gap.after:.3g} after, white noise {gap.noise:.3g}"
    )


def _options(choices: dict[str, Any]) -> dict[str, Any]:
    kind: Kind = choices["kind"]
    return {"kind": kind, "seed": choices["seed"], "starts": choices["starts"]}


def _written(finding: Finding, campaign: Campaign, out: Path, seed: int) -> None:
    data = as_json(finding, measured=campaign.measured, seed=seed)
    folder = out / "discrepancy"
    write_json(folder / f"joint{finding.joint}.json", data)
    write_text(
        folder / f"joint{finding.joint}.html", discrepancy_page(finding, campaign.title, measured=campaign.measured)
    )
    click.echo(f"joint {finding.joint}: {data['verdict']}. {finding.judgement.sentence}")
    for name, gap in finding.gaps.items():
        share, beside = gap.closed_beside_scatter, "" if gap.beside is None else " beside the scatter"
        closed = "" if share is None else f", {100 * share:.1f} % of the gap{beside} closed"
        click.echo(f"  {name}: RMS {gap.before:.3g} before, {gap.after:.3g} after, noise {gap.noise:.3g}{closed}")
    made = f", {data['fmu']}" if data["fmu"] else ""
    click.echo(f"  written below {out}: discrepancy/joint{finding.joint}.json, .html{made}")


if __name__ == "__main__":
    main()
