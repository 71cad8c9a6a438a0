"""Find what is missing in the models of joints: folder of a campaign in, findings and their pages out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from haptid.api.find_missing import carry_out
from haptid.api.place import Place
from haptid.discrepancy.finding.stages import run_stages
from haptid.discrepancy.job.job import Job, catalogue_without
from haptid.discrepancy.job.search import (
    Prepared,
    SearchByPosition,
    WholeCheck,
    moves_whole,
    need_of,
    prepare_alone,
    prepare_together,
    prepare_whole,
)
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.sequence.carried_fit import FILE
from haptid.measurement.checks.motion import in_first_postures
from haptid.measurement.checks.preparation import campaign_for_command, tell_remarks
from haptid.report.discrepancy.stage_pictures import save, stage_figure
from haptid.support.command import listening, parse_joints, word_again
from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.listener import Listener

Findings = dict[str, dict[str, Any]]
"""Content of findings by the name of their file."""


def search_campaign(  # one argument an option
    campaign: Path | str | None,
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

    Raises
    ------
    InputError
        Where the campaign, the options or the user's effects are wrong, or the campaign has no runs to search.
    WritingError
        Where ``out`` cannot be written.
    """
    catalogue = catalogue_without({part for part in without.split(",") if part}, effects)
    whole = campaign_for_command(campaign)
    read = in_first_postures(whole)
    together = _parse_together(free)
    chosen = _parse_alone(joint, joints)
    several: tuple[tuple[int, ...], ...] = (tuple(sorted(together)),) if together else ()
    if not chosen and not several:
        chosen, several = read.joints, tuple(c for c in read.configurations if len(c) > 1)
    if not chosen and not several:
        raise InputError("campaign.toml", expected="runs with one free joint", got="none")
    job = Job(
        campaign=read, catalogue=catalogue, out=out, kind=choices["kind"], seed=choices["seed"],
        starts=choices["starts"], effort=choices["effort"], threads=choices["workers"],
    )  # fmt: skip
    findings: Findings = {}
    with listening(quiet=choices["quiet"]) as listener:
        tell_remarks(read, listener)
        if len(read.runs) < len(whole.runs):
            left = len(whole.runs) - len(read.runs)
            listener.note(f"note: {left} runs are not searched: their joints are locked in a further posture")
        if choices["scheduler"]:
            listener.note("note: --scheduler is not used, the search runs here on --workers threads")
        # All are prepared before the first search begins, so that input is refused before any long work.
        alone = [prepare_alone(job, j) for j in chosen]
        _check_stage(alone, choices["stage"])
        with _telling_kept(findings, chosen, several):
            for search in alone:
                findings |= _find(search, choices["stage"], listener)
            # These are prepared afterwards: their models hold what was found in the joints alone.
            for free_joints in several:
                prepared = _prepare_together(job, free_joints, choices["stage"], listener, asked=together is not None)
                if prepared is not None:
                    findings |= _find(prepared, choices["stage"], listener)
    return findings.popitem()[1] if joint is not None and len(findings) == 1 else findings


def _parse_together(free: str | None) -> tuple[int, ...] | None:
    """Parse the joints of ``--free``, which are several."""
    together = parse_joints(free, "--free")
    if together is not None and len(set(together)) < 2:
        what = f"joints that move together, as in --free {together[0]},{together[0] + 1}"
        todo = f"search one joint alone by --joints {together[0]}"
        raise InputError("--free", expected=what, got=str(free), todo=todo)
    return together


@contextmanager
def _telling_kept(findings: Findings, alone: Sequence[int], several: Sequence[tuple[int, ...]]) -> Iterator[None]:
    """Say with an interruption which findings are left, where there are any, and how the others are searched."""
    try:
        yield
    except KeyboardInterrupt as stop:
        if findings:
            stop.args = (_tell_kept(findings, alone, several),)
        raise


def _tell_kept(findings: Findings, alone: Sequence[int], several: Sequence[tuple[int, ...]]) -> str:
    left = alone[len(findings) :]
    together = several[max(len(findings) - len(alone), 0) :]
    options = [f"--joints {','.join(map(str, left))}"] if left else []
    options += [f"--free {','.join(map(str, joints))}" for joints in together]
    kept = ", ".join(f"discrepancy/{name}.json" for name in findings)
    commands = [word_again("missing", "discrepancy.run", ("--joint", "--joints", "--free"), one) for one in options]
    rest = f"; go on with: {', then '.join(commands)}" if options else ""
    return f"{kept} kept{rest}"


def _parse_alone(joint: int | None, joints: str | None) -> tuple[int, ...]:
    """Read which joints are studied, each alone."""
    if joint is not None and joints:
        got, todo = f"--joint {joint} and --joints {joints}", "--joints studies several, each alone"
        raise InputError("--joint", expected="one of --joint and --joints", got=got, todo=todo)
    return ((joint,) if joint is not None else parse_joints(joints)) or ()


def _prepare_together(
    job: Job, joints: tuple[int, ...], stage: str, listener: Listener, *, asked: bool
) -> SearchByPosition | WholeCheck | None:
    """Prepare the study of joints that move together.

    Where nobody asked for these joints, what cannot be done is left out and not refused: more of them than a search
    takes on are only simulated.
    """
    fitted = bool(job.campaign.runs_of(joints, "fit"))
    if stage != "all" and not fitted:
        if not asked:
            return None
        where, got = f"--stage {stage}", f"--free {','.join(map(str, joints))} without runs to fit"
        raise InputError(where, expected="joints with runs to fit", got=got)
    if asked or (fitted and len(joints) <= THRESHOLDS.study.most_joints):
        return prepare_together(job, joints)
    if stage != "all" or not moves_whole(job, joints):
        return None
    if not (job.out / FILE).exists():
        listener.note(f"note: {need_of(job)}")
        return None
    return prepare_whole(job, joints)


def _check_stage(searches: Sequence[Prepared], stage: str) -> None:
    """Refuse a stage alone where a joint is searched in torque, which has no such stages."""
    swept = [search for search in searches if not isinstance(search, SearchByPosition)]
    if swept and stage != "all":
        where, got = f"--stage {stage}", f"{swept[0].title}, swept by position"
        raise InputError(where, expected="a joint that torque drives", got=got)


def _find(search: Prepared, stage: str, listener: Listener) -> Findings:
    """Carry out a search, or one stage of it; tell and return what was written."""
    out = search.job.out
    if isinstance(search, SearchByPosition) and stage != "all":
        return _run_stage(search, stage, listener)
    made = carry_out(search, Place(out), listener)
    below = f"  written below {out}: discrepancy/{made.name}.json, .html"
    fmu = f", {made.data['fmu']}" if made.data.get("fmu") else ""
    listener.finished([*made.told(), f"{below}{fmu}"])
    return {made.name: made.data}


def _run_stage(search: SearchByPosition, stage: Any, listener: Listener) -> Findings:
    job, out = search.job, search.job.out
    done = run_stages(search.study, stage, seed=job.seed, starts=job.starts, tell=listener.progress)
    name = f"{search.name}_{done.stage}"
    data = done.as_json(measured=job.campaign.measured)
    write_json(out / "discrepancy" / f"{name}.json", data)
    save(stage_figure(done), out / "discrepancy" / f"{name}.png")
    listener.finished([f"{search.title}: {done.sentence}", f"  written below {out}: discrepancy/{name}.json, .png"])
    return {name: data}
