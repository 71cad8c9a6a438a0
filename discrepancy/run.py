"""``python -m discrepancy.run [CAMPAIGN] --joint J``: what is missing in the model of a joint, if anything."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from haptid.discrepancy.commands import missing as main
from haptid.discrepancy.finding.accuracy import origin_of
from haptid.discrepancy.finding.finding import Finding, as_json, find
from haptid.discrepancy.finding.full_model import whole_finding
from haptid.discrepancy.finding.stages import run_stages
from haptid.discrepancy.finding.torque_finding import find_torque, torque_json
from haptid.discrepancy.study.coupled_study import coupled_study_of
from haptid.discrepancy.study.study import Study, begun_at, study_of, with_positions
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.choice import is_searched_by_torque, read_carried_fit, read_zeros
from haptid.discrepancy.torque.study import torque_study_of
from haptid.fmu_build.building.packaging import Kind
from haptid.fmu_build.exchange.discrepancy_json import VERDICTS, by_joint, finding_of, read_discrepancy
from haptid.fmu_build.exchange.discrepancy_json import Finding as JointFinding
from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.preparation import campaign_for_command, tell_remarks
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.units import unit_for
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import with_folder
from haptid.report.common.stored_page import write_page
from haptid.report.discrepancy.page import discrepancy_page
from haptid.report.discrepancy.stage_pictures import save, stage_picture, write_pictures
from haptid.report.discrepancy.torque_gap_page import torque_gap_page
from haptid.report.discrepancy.whole_gap_page import whole_gap_page
from haptid.support.command import parse_joints, progress, word_command
from haptid.support.errors import InputError
from haptid.support.files.files import write_json

Findings = dict[str, dict[str, Any]]
"""Content of findings by the name of their file."""


def search_campaign(
    campaign: str | None,
    out: Path,
    joints: str | None,
    *,
    joint: int | None,
    free: str | None,
    effects: Path | None,
    without: str,
    **choices: Any,
) -> dict[str, Any]:
    """Find what is missing in the models of joints, and write and tell the findings.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    out
        Folder of the results.
    joints
        Numbers of the joints to study, each alone, separated by commas; None for all.
    joint
        Number of the one joint to study; None for those of ``joints``.
    free
        Numbers of the joints that move together, separated by commas.
    effects
        Folder with effects of the user's own.
    without
        Ids of effects to leave out, separated by commas.
    choices
        Further options of the command by name.

    Returns
    -------
    dict
        The finding of ``joint``; where another choice was made, the findings by the name of their file.
    """
    left_out = {part for part in without.split(",") if part}
    entries = {key: e for key, e in with_folder(effects).items() if not {key, e.id} & left_out}
    if unknown := left_out - {name for key, e in with_folder(effects).items() for name in (key, e.id)}:
        raise InputError("--without", expected="ids of the catalogue", got=", ".join(sorted(unknown)))
    read = campaign_for_command(campaign)
    together = parse_joints(free, "--free")
    chosen = ((joint,) if joint is not None else parse_joints(joints)) or ()
    several: tuple[tuple[int, ...], ...] = (tuple(sorted(together)),) if together else ()
    if not chosen and not several:
        chosen, several = read.joints, tuple(c for c in read.configurations if len(c) > 1)
    if not chosen and not several:
        raise InputError("campaign.toml", expected="runs with one free joint", got="none")
    tell_remarks(read)
    if choices["scheduler"]:
        click.echo("note: --scheduler is not used, the search runs here on --workers threads", err=True)
    findings = _alone(read, chosen, entries, out, choices)
    for free_joints in several:
        findings |= _together(read, free_joints, entries, out, choices, asked=together is not None)
    return findings.popitem()[1] if joint is not None and len(findings) == 1 else findings


def _alone(
    read: Campaign, chosen: tuple[int, ...], entries: dict[str, Effect], out: Path, choices: dict[str, Any]
) -> Findings:
    """Study joints, each in the runs in which it moves alone; return what was written."""
    findings: Findings = {}
    swept = [j for j in chosen if is_searched_by_torque(read, j, out)]
    if swept and choices["stage"] != "all":
        where = f"--stage {choices['stage']}"
        raise InputError(where, expected="a joint that torque drives", got=f"joint {swept[0]}, swept by position")
    for j in swept:
        findings |= _torque(read, j, entries, out, choices)
    # All studies are built before the first search begins, so that input is refused before any long work.
    for study in [study_of(read, j, entries, threads=choices["workers"]) for j in chosen if j not in swept]:
        findings |= _study(study, read, out, choices)
    return findings


def _together(
    read: Campaign,
    joints: tuple[int, ...],
    entries: dict[str, Effect],
    out: Path,
    choices: dict[str, Any],
    *,
    asked: bool,
) -> Findings:
    """Study the runs in which several joints move; return what was written.

    A search is run where some of these runs are to be fitted and the joints are few; otherwise the identified model is
    simulated in them.
    """
    findings = [f for j in joints if (f := _find_named(out, j, entries)) is not None]
    # Where nobody asked for these joints, more of them than a search takes on are only simulated, and not refused.
    if read.runs_of(joints, "fit") and (asked or len(joints) <= THRESHOLDS.study.most_joints):
        known = by_joint(findings)
        study = coupled_study_of(read, joints, entries, known, threads=choices["workers"])
        return _study(study, read, out, choices)
    if choices["stage"] != "all":
        if asked:
            where, got = f"--stage {choices['stage']}", f"--free {','.join(map(str, joints))} without runs to fit"
            raise InputError(where, expected="joints with runs to fit", got=got)
        return {}
    runs, device, source = read.runs_of(joints, "validate"), device_of(read), out / "identification.json"
    if device is None or not runs or len(joints) < len(device.joints):
        if asked:
            where = f"--free {','.join(map(str, joints))}"
            raise InputError(where, expected="runs in which these joints move together", got="none that tells")
        return {}
    if not source.exists():
        making = word_command("identify", "identification.run")
        note = f"runs with all joints free need {source}: {making} makes it"
        if asked:
            raise InputError("--free", expected=f"an identified model, {source}", got="no such file", todo=note)
        click.echo(f"note: {note}", err=True)
        return {}
    identification = read_identification(source)
    finding = whole_finding(read, device, runs, identification, findings)
    data = finding.as_json(measured=read.measured)
    write_json(out / "discrepancy" / "whole.json", data)
    write_page(out / "discrepancy" / "whole.html", whole_gap_page(finding, read.title, measured=read.measured))
    click.echo(f"all joints: {finding.verdict}. {finding.sentence}")
    click.echo(f"  written below {out}: discrepancy/whole.json, .html")
    return {"whole": data}


def _find_named(out: Path, joint: int, entries: dict[str, Effect]) -> JointFinding | None:
    """Return the named effects of a joint that was tested alone; None where it was not studied or nothing was named."""
    path = out / "discrepancy" / f"joint{joint}.json"
    if not path.exists():
        return None
    data = read_discrepancy(path)
    return finding_of(data, str(path), entries) if data["verdict"] in VERDICTS else None


def _study(study: Study, read: Campaign, out: Path, choices: dict[str, Any]) -> Findings:
    carried = read_carried_fit(read, study.fitted[0].free_joints, study.base, out)
    study = begun_at(replace(study, effort=choices["effort"]), carried)
    zeros = read_zeros(read, study.fitted[0].free_joints, out)
    if zeros:
        study = with_positions(study, zeros)
        click.echo(f"{study.title.lower()}: the encoder zeros of {out / FILE} are taken out of the readings", err=True)
    bar: Any = progress(total=None, title=study.title.lower(), quiet=choices["quiet"])
    if choices["stage"] != "all":
        with bar:
            options = {"seed": choices["seed"], "starts": choices["starts"]}
            done = run_stages(study, choices["stage"], **options, tell=bar.set_description)
        name = f"{study.name}_{done.stage}"
        data = done.as_json(measured=read.measured)
        write_json(out / "discrepancy" / f"{name}.json", data)
        save(stage_picture(done), out / "discrepancy" / f"{name}.png")
        click.echo(f"{study.title.lower()}: {done.sentence}\n  written below {out}: discrepancy/{name}.json, .png")
        return {name: data}
    with bar:
        origin = origin_of(read, study.fitted[0].free_joints)
        finding = find(study, out, **_options(choices), tell=bar.set_description, origin=origin)
    return {study.name: _write_finding(finding, read, out, choices["seed"])}


def _torque(read: Campaign, joint: int, entries: dict[str, Effect], out: Path, choices: dict[str, Any]) -> Findings:
    """Study a joint that a position controller swept; its torque is scored."""
    bar: Any = progress(total=None, title=f"joint {joint}", quiet=choices["quiet"])
    with bar:
        carried = read_carried_fit(read, (joint,), equations_for(read, device_of(read), (joint,)), out, springless=True)
        study = torque_study_of(read, joint, carried, threads=choices["workers"])
        options = {**_options(choices), "tell": bar.set_description, "origin": origin_of(read, (joint,))}
        finding = find_torque(study, entries, out, **options)
    folder, name = out / "discrepancy", f"joint{joint}"
    data = torque_json(finding, measured=read.measured, seed=choices["seed"])
    write_json(folder / f"{name}.json", data)
    write_page(folder / f"{name}.html", torque_gap_page(finding, read.title, measured=read.measured))
    gap = finding.gaps["validate"]
    click.echo(f"joint {joint}: {finding.verdict}. {finding.sentence}")
    unit = unit_for("N m", [study.prismatic])
    click.echo(
        f"  held-out torque: RMS {gap.before:.3g} {unit} before, {gap.after:.3g} after, white noise {gap.noise:.3g}"
    )
    return {name: data}


def _options(choices: dict[str, Any]) -> dict[str, Any]:
    kind: Kind = choices["kind"]
    return {"kind": kind, "seed": choices["seed"], "starts": choices["starts"]}


def _write_finding(finding: Finding, campaign: Campaign, out: Path, seed: int) -> dict[str, Any]:
    data, study = as_json(finding, measured=campaign.measured, seed=seed), finding.search.study
    folder = out / "discrepancy"
    write_json(folder / f"{study.name}.json", data)
    write_page(folder / f"{study.name}.html", discrepancy_page(finding, campaign.title, measured=campaign.measured))
    write_pictures(finding, folder)
    click.echo(f"{study.title.lower()}: {data['verdict']}. {finding.judgement.sentence}")
    for name, gap in finding.gaps.items():
        share, beside = gap.closed_beside_scatter, "" if gap.beside is None else " beside the scatter"
        closed = "" if share is None else f", {100 * share:.1f} % of the gap{beside} closed"
        click.echo(f"  {name}: RMS {gap.before:.3g} before, {gap.after:.3g} after, noise {gap.noise:.3g}{closed}")
    made = f", {data['fmu']}" if data["fmu"] else ""
    click.echo(f"  written below {out}: discrepancy/{study.name}.json, .html{made}")
    return data


if __name__ == "__main__":
    main()
