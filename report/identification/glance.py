"""The first screen of an identification: steps, verification and files in, a table with one line a joint out."""

from __future__ import annotations

from collections.abc import Sequence

from haptid.identification.output.summary import residual_unit, worst_score
from haptid.identification.sequence.outcome_sentence import LINEAR_HOLD, seems_held_by_mistake
from haptid.identification.sequence.step import Step
from haptid.identification.statistics.absent import absent_ids
from haptid.identification.verification.result import JointCheck, RunCheck, Verification
from haptid.measurement.values.units import unit_for
from haptid.report.common.numbers import in_thousandths
from haptid.report.common.page import Cell, Table
from haptid.report.common.words import Word, word_of
from haptid.support.numbers import plain

RESULT = "identification.json"


def glance_table(steps: Sequence[Step], verification: Verification, files: Sequence[str]) -> Table:
    """Write one line for each configuration, and one for the whole model.

    Parameters
    ----------
    steps
        Fitted configurations.
    verification
        Check of the whole model.
    files
        FMUs and parameter sets that were written, relative to the page.

    Returns
    -------
    Table
        Verdict, residual of the worst run that no fit saw (of the worst fitted one where there is none), what to do,
        and the files.
    """
    advised: dict[str, str] = {}
    rows = [_step_row(step, files, advised) for step in steps]
    own = {file for step in steps for file in _files_of(step, files)}
    rest = [file for file in files if file not in own]
    if verification.runs or rest:
        rows.append(_whole_row(verification, rest))
    unseen = any(score.use == "validate" for step in steps for score in step.fit.runs)
    worst = "worst unseen run" if unseen else "worst run"
    header = ("joint", "verdict", f"RMS, {worst}", "× noise", worst, "what to do next", "files")
    return Table(header=header, rows=rows)


def _files_of(step: Step, files: Sequence[str]) -> list[str]:
    """Return the files of one joint alone."""
    joints = step.configuration.free_joints
    stems = {f"joint{joints[0]}", f"joint{joints[0]}_native"} if len(joints) == 1 else set()
    return [file for file in files if file.rsplit(".", 1)[0] in stems]


def _step_row(step: Step, files: Sequence[str], advised: dict[str, str]) -> tuple[str | Cell, ...]:
    """Return the line of a configuration; ``advised`` collects which one has a piece of advice first."""
    word, worst = word_of(f"fit-{step.fit.outcome.label}"), worst_score(step)
    unit = residual_unit(step)
    size = "–" if worst is None else in_thousandths(worst.rmse_rad, unit)
    over = "–" if worst is None else plain(worst.over_noise, 3)
    run = "–" if worst is None else f"{worst.file} ({worst.use})"
    links = (*_files_of(step, files), RESULT)
    said = step.configuration.name + (" (torque)" if step.torque_scored else "")
    name = Cell(text=said, anchor=step.configuration.anchor)
    return (
        name,
        Cell(text=word.text, word=word.key),
        size,
        over,
        run,
        _next_action(step, word, advised, is_exported=bool(files)),
        Cell(links=links),
    )


def _next_action(step: Step, word: Word, advised: dict[str, str], *, is_exported: bool) -> str:
    """Say what to do: first of all mend a held torque; after a fit at the noise, what is open in its parameters.

    What is said of open parameters in an earlier line is not repeated. Where no FMU was written, its command is named.
    """
    if word.level != "good" and seems_held_by_mistake(step):
        return f"State {LINEAR_HOLD} and fit again: the torque acts half a row before it is recorded."
    use = word.action if word.level != "good" or is_exported else f"{word.action} haptid export writes the FMU."
    absent = absent_ids(step.fit)  # no run can tell them; the page says that they are absent
    for status in ("at_bound", "unidentifiable") if word.level == "good" else ():
        ids = [id for id, one in step.fit.statuses.items() if one == status and id not in absent]
        if ids:
            found = word_of(f"status-{status}")
            action = _tell_apart(step) if status == "unidentifiable" else found.action
            first = advised.setdefault(f"{status} {action}", step.configuration.name)
            if first != step.configuration.name:
                return f"{use} {', '.join(ids)}: {found.text}, as for {first}."
            return f"{use} {', '.join(ids)}: {found.text} ({found.plain}). {action}"
    return use


def _tell_apart(step: Step) -> str:
    """Say what to do about parameters that are not known: only what this page lists, and this device can do."""
    listed = "Use the combination that the page lists, or " if step.fit.combinations else ""
    # A single joint has no other joints that could be locked elsewhere, which is what haptid plan proposes.
    other = "run haptid plan for tests" if step.configuration.posture else "make runs"
    said = f"{listed}{other} that tell them apart."
    return said[0].upper() + said[1:]


def _whole_row(verification: Verification, files: Sequence[str]) -> tuple[str | Cell, ...]:
    links = Cell(links=(*files, RESULT))
    if verification.outcome is None:
        return "all joints", "–", "–", "–", "–", "No run with all joints free judges the device: make one.", links
    word = word_of(f"whole-{verification.outcome}")
    run, joint = worst_joint(verification)
    size = in_thousandths(joint.rmse_rad, unit_for("rad", [joint.prismatic]))
    verdict = Cell(text=word.text, word=word.key)
    where = f"{run.file} ({run.mode.replace('_', ' ')})"
    over = plain(joint.rmse_over_noise, 3)
    return (
        Cell(text="all joints", anchor="whole"),
        verdict,
        f"{size} (joint {joint.joint})",
        over,
        where,
        word.action,
        links,
    )


def worst_joint(verification: Verification) -> tuple[RunCheck, JointCheck]:
    """Return the joint that the whole model misses most over its noise, and the run.

    Parameters
    ----------
    verification
        Check of the whole model with at least one run.

    Returns
    -------
    run : RunCheck
    joint : JointCheck
    """
    pairs = [(run, joint) for run in verification.runs for joint in run.joints]
    return max(pairs, key=lambda pair: pair[1].rmse_over_noise)
