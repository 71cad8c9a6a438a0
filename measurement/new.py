"""``python -m measurement.new FOLDER --out DIR``: make a campaign from a folder of tables."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import tomli_w

from haptid.measurement.asking.dialogue import ask_until_agreed
from haptid.measurement.asking.questions import assume_facts, assume_step, assume_validation
from haptid.measurement.checks.preparation import ready_for_fits
from haptid.measurement.commands import init as main
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.answers import Answers
from haptid.measurement.making.from_flags import answers_of, complete
from haptid.measurement.making.logged_table import TEXTS, is_table, read_logged_table
from haptid.measurement.making.prepared import (
    PreparedTable,
    current_constants,
    describe,
    describe_campaign,
    describe_drives,
    map_currents,
    prepare_tables,
)
from haptid.measurement.making.stated_rate import with_time_of_rate
from haptid.measurement.making.times import assume_time, with_seconds
from haptid.measurement.making.users_places import name_users_places
from haptid.measurement.making.writing import refuse_overwrite, write_table
from haptid.measurement.naming.encoder_counts import refuse_open_counts
from haptid.measurement.naming.map_option import parse_map, remarks_on_grad, remarks_on_units
from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.units_in_names import known_names
from haptid.measurement.recordings.mat_runs import OTHER_LENGTH
from haptid.measurement.recordings.recording import KINDS, names_of_recordings, recordings_in
from haptid.measurement.tables.table import SUFFIXES, Table
from haptid.measurement.tables.thousands import refuse_thousands
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.command import word_command
from haptid.support.errors import LONGEST, InputError, one_line, shorten
from haptid.support.files.files import is_file, write_bytes, write_text
from haptid.support.numbers import count_of

SPREADSHEETS = (".xlsx", ".xls", ".ods")
"""Ends of files that are tables to their user, and no text."""
LONGEST_LIST = 160
"""Characters of a list of files in a line for the user."""


def make_campaign(
    folder: Path, out: Path, maps: tuple[str, ...], **flags: str | float | bool | tuple[str, ...] | None
) -> dict[str, Any]:
    """Make a campaign from a folder of tables, and tell what was written.

    Parameters
    ----------
    folder
        Folder with one table per run.
    out
        New folder for the campaign.
    maps
        Values of ``--map``.
    flags
        Further options of the command by name; None where absent.

    Returns
    -------
    dict
        Folder, title, device and runs of the campaign, the lines on how its tables were read, what was assumed, the
        remarks on likely slips, and why a fit would refuse the campaign (None where none would).

    Raises
    ------
    InputError
        Where the folder holds no table that can be read, the new folder is not empty, or an answer or option is at
        fault.
    """
    refuse_overwrite(out)
    stated = parse_map(maps)
    tables, layouts = _tables(folder, stated)
    tables, timed = _assume_times(tables, stated)
    yes, assumed = bool(flags.pop("yes", False)), list[str]()
    asks, given = _can_ask() and not yes, dict(flags)
    if yes:
        given, assumed = assume_facts(folder, tables, given)
    elif not asks:
        given, assumed = assume_validation(tables, given)
    if not asks:
        given, counted = assume_step(tables, stated, given)
        assumed += counted
    if asks:
        answers, prepared = ask_until_agreed(folder, tables, given, stated, [*layouts, *timed])
    else:
        assumed += timed
        answers = answers_of(folder, tables, given, stated)
        with _all_that_lacks(tables, answers, origin=given["measured"] is not None), _telling_left_out(layouts):
            if answers.resolution is None:
                refuse_open_counts(tables, stated)
            prepared = complete(prepare_tables(tables, answers), answers)
        click.echo("\n".join([*layouts, *describe(prepared), *describe_drives(prepared, answers)]))
    assumed += _assume_one_constant(prepared, answers)
    written = _write_checked(out, folder, prepared, answers)
    if assumed:
        click.echo("\n".join(["assumed, unless a flag says otherwise:", *(f"  {sentence}" for sentence in assumed)]))
    _tell_written(written, out)
    understood = {
        column: {"name": target.name, "factor": target.factor}
        for one in prepared
        for column, target in one.targets.items()
    }
    campaign = written.campaign
    runs = [{"file": run.file, "free_joints": list(run.free_joints), "use": run.use} for run in campaign.runs]
    head = {"campaign": str(out), "title": campaign.title, "device": written.device, "measured": campaign.measured}
    found = {"remarks": written.remarks, "refused": written.refused or None}
    return {**head, "understood": understood, "runs": runs, "layouts": layouts, "assumed": assumed, **found}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Written:
    """A campaign that was written, and what its check said.

    Parameters
    ----------
    campaign
        As it was read from its draft.
    device
        Its device, by its place in the written campaign.
    refused
        Why a fit would refuse the campaign; empty where none would.
    remarks
        On likely slips.
    """

    campaign: Campaign
    device: str
    refused: str
    remarks: list[str]


def _write_checked(out: Path, folder: Path, prepared: list[PreparedTable], answers: Answers) -> _Written:
    """Write and check a campaign beside its place, then move it: one that cannot be read never has its name."""
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as draft:
        inner = Path(draft) / out.name
        _write(inner, prepared, answers)
        with warnings_on_stderr(renamed=(str(inner), str(folder))):
            campaign = _check_draft(inner, folder, prepared)
        refused, remarks = _ask_check(campaign, renamed=(str(inner), str(out)))
        understood = {column: target for one in prepared for column, target in one.targets.items()}
        on_units = [*remarks_on_units(answers.stated), *remarks_on_grad(understood, answers.stated)]
        remarks = [*on_units, *_remark_on_constant(prepared, answers), *remarks]
        if out.exists():
            out.rmdir()
        shutil.move(inner, out)
    device = campaign.device.replace(str(inner), str(out))
    return _Written(campaign=campaign, device=device, refused=refused, remarks=remarks)


def _tell_written(written: _Written, out: Path) -> None:
    campaign = written.campaign
    kinds = "; ".join("+".join(map(str, joints)) for joints in campaign.configurations)
    count = count_of(len(campaign.runs), "run")
    click.echo(f"wrote {out}: {count}, free joints {kinds}, {campaign.label} data, device {written.device}")
    for remark in written.remarks:
        click.echo(f"remark: {remark}", err=True)  # as all commands tell theirs: not lost where stdout is
    check = f"{word_command('check', 'measurement.check')} {out}"
    click.echo(f"to mend before a fit: {written.refused}" if written.refused else f"next: {check}")


def _check_draft(draft: Path, folder: Path, prepared: list[PreparedTable]) -> Campaign:
    """Read the draft; an error names the user's own files instead of the draft's."""
    try:
        return read_campaign(draft)
    except InputError as error:
        where = name_users_places(error.where, draft, folder, prepared)
        expected = error.expected.replace(str(draft), str(folder))
        raise InputError(where, expected=expected, got=error.got, todo=error.todo) from None


def _assume_one_constant(prepared: list[PreparedTable], answers: Answers) -> list[str]:
    """Return a sentence on the torque of an ampere, where several motors get the same."""
    constant = answers.torque_constant
    own = {} if constant is None else map_currents(prepared, constant)
    if constant is None or len(own) < 2:
        return []
    joints = ", ".join(map(str, own))
    return [f"an ampere gives {constant:g} N m (N) at each of joints {joints} (each its own: {own[max(own)]})"]


def _remark_on_constant(prepared: list[PreparedTable], answers: Answers) -> list[str]:
    """Return a remark where the torque of an ampere turns the sign of a recorded current round."""
    constant = answers.torque_constant
    if constant is None or constant > 0.0 or not current_constants(prepared):
        return []
    return [f"--torque-constant {constant:g} is below 0: the torque has the opposite sign of the recorded current"]


def _ask_check(campaign: Campaign, renamed: tuple[str, str]) -> tuple[str, list[str]]:
    """Return why `measurement.check` would refuse a campaign, empty where it would not, and its remarks on slips."""
    try:
        remarks = ready_for_fits(campaign).remarks
    except InputError as error:
        return str(error).replace(*renamed), []
    return "", [shorten(one_line(remark.replace(*renamed)), LONGEST) for remark in remarks]


def _tables(folder: Path, stated: Mapping[str, Target]) -> tuple[list[Table], list[str]]:
    """Return the tables, a line on each that has another layout than the campaign format, and one on files beside."""
    if is_file(folder):
        todo = f"name its folder, as in {word_command('init', 'measurement.new')} {folder.parent}"
        raise InputError(str(folder), expected="a folder of tables", got="a file", todo=todo)
    if not folder.is_dir():
        raise InputError(str(folder), expected="a folder of tables", got="no such folder")
    paths = sorted(path for path in folder.iterdir() if path.name.endswith(SUFFIXES))
    # A text of any name may be a table, or notes beside recordings.
    texts = sorted(path for path in folder.iterdir() if path.name.endswith(TEXTS) and is_file(path))
    texts = [path for path in texts if _holds_table(path, beside=bool(paths))]
    if not paths and not texts:
        return _recordings(folder)
    read = [_read_further(*read_logged_table(path), stated) for path in paths or texts]
    left = [*(path.name for path in texts if paths), *names_of_recordings(folder), *_spreadsheets(folder)]
    return [table for table, _ in read], [*_layout_lines(read), *_lines_on_left(left)]


def _holds_table(path: Path, *, beside: bool) -> bool:
    """Whether a text holds a table; one beside tables is not needed, and may be one that cannot be read."""
    try:
        return is_table(path)
    except InputError:
        if beside:
            return False
        raise


def _spreadsheets(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.suffix.lower() in SPREADSHEETS)


def _lines_on_left(names: list[str]) -> list[str]:
    """Return a line on files that are left alone, since they mostly hold the runs of the tables once more."""
    told = f"not read beside the tables: {shorten(', '.join(names), LONGEST_LIST)}"
    return [f"{told}; if other runs, make a campaign of them in a folder of their own"] if names else []


def _read_further(table: Table, layout: str, stated: Mapping[str, Target]) -> tuple[Table, str]:
    refuse_thousands(table)
    table, dates = with_seconds(table, stated)
    table, counted = with_time_of_rate(table, stated)
    return table, ", ".join(words for words in (layout, dates, counted) if words)


def _assume_times(tables: list[Table], stated: dict[str, Target]) -> tuple[list[Table], list[str]]:
    """Return the tables with times in seconds where a name has no unit, and a sentence on each such name and unit."""
    read = [assume_time(table, stated) for table in tables]
    assumed = dict.fromkeys(one for _, one in read if one is not None)
    return [table for table, _ in read], [f"{one.column!r} is in {one.words} ({one.other})" for one in assumed]


def _layout_lines(read: list[tuple[Table, str]]) -> list[str]:
    """Return a line on each layout that is not that of the campaign format, with the tables that have it."""
    files: dict[str, list[str]] = {}
    for table, layout in read:
        if layout:
            files.setdefault(layout, []).append(table.path.name)
    return [f"{', '.join(names)} {'have' if len(names) > 1 else 'has'} {layout}" for layout, names in files.items()]


def _recordings(folder: Path) -> tuple[list[Table], list[str]]:
    """Return the runs of a folder without tables, and a line on each that says more than its columns."""
    read = recordings_in(folder)
    if not read:
        expected = f"tables that end in {', '.join((*SUFFIXES, *TEXTS, *KINDS))}"
        texts = sorted(path.name for path in folder.iterdir() if path.name.endswith(TEXTS))
        if texts:
            todo = (
                "write a line with the names and units of the columns before the rows, as in 'time_s torque_Nm q_rad'"
            )
            raise InputError(
                str(folder / texts[0]), expected="a table", got="no line of names above numbers", todo=todo
            )
        if sheets := _spreadsheets(folder):
            raise InputError(str(folder / sheets[0]), expected=expected, got="a spreadsheet", todo="save it as CSV")
        raise InputError(str(folder), expected=expected, got="none")
    names = [one.table.file_name for one in read]
    for name in names:
        if names.count(name) > 1:
            raise InputError(str(folder), expected=f"one run {name}", got="several", todo="rename one of the files")
    return [one.table for one in read], [f"{one.table.file_name}: {one.about}" for one in read if one.about]


@contextmanager
def _all_that_lacks(tables: list[Table], answers: Answers, *, origin: bool) -> Iterator[None]:
    """Add to an error within the block the other options that lack: one refusal after another is tedious.

    ``origin`` says whether it is known where the data come from.
    """
    try:
        yield
    except InputError as error:
        options = _options_that_lack(tables, answers, error, origin=origin)
        # An error without an option to give, as of a damaged cell, is another matter.
        if "--" not in error.todo or not options:
            raise
        todo = f"{error.todo}; also {', '.join(options)}"
        raise InputError(error.where, expected=error.expected, got=error.got, todo=todo) from None
    if not origin:
        where = "--measured or --synthetic"
        todo = "say whether a device was measured or the data were simulated"
        raise InputError(where, expected="one of the two flags", got="neither", todo=todo)


@contextmanager
def _telling_left_out(layouts: list[str]) -> Iterator[None]:
    """Add to an error within the block which vectors of its recording have another length: one may be what it lacks."""
    try:
        yield
    except InputError as error:
        stem = Path(error.where).stem
        own = [line for line in layouts if line.startswith((f"{stem}.", f"{stem}_"))]
        said = [line.partition(": ")[2] for line in own if OTHER_LENGTH in line]
        if not said:
            raise
        todo = f"cut them to the same rows where they belong together; else {error.todo}"
        raise InputError(error.where, expected=error.expected, got=f"{error.got}; {said[0]}", todo=todo) from None


def _options_that_lack(tables: list[Table], answers: Answers, error: InputError, *, origin: bool) -> list[str]:
    """List the options that lack beside those that an error names."""
    options = []
    known = known_names(tables[0].columns, answers.stated)
    a_torque = any(name.startswith(("torque_", "force_")) for name in known)
    a_current = any(name.startswith("current_") for name in known) or "=current_" in error.todo
    if a_current and not a_torque and answers.torque_constant is None:
        options.append("--torque-constant [N m/A]")
    if not origin:
        options.append("--measured or --synthetic")
    return [option for option in options if option not in error.todo]


def _can_ask() -> bool:
    return sys.stdin.isatty()


def _write(folder: Path, prepared: list[PreparedTable], answers: Answers) -> None:
    for one in prepared:
        write_table(folder / one.file, one.frame)
    device = _copy_device(str(answers.device), folder)
    write_text(folder / "campaign.toml", tomli_w.dumps(describe_campaign(prepared, answers, device)))


def _copy_device(device: str, folder: Path) -> str:
    """Copy a device file that exists here into the campaign, which stays whole wherever it goes."""
    path = Path(device)
    if path.suffix not in (".toml", ".urdf") or not is_file(path):
        return device
    name = f"device_{path.name}" if path.name == "campaign.toml" else path.name
    write_bytes(folder / name, path.read_bytes())
    return name


if __name__ == "__main__":
    main()
