"""``python -m measurement.new FOLDER --out DIR``: make a campaign from a folder of tables."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import tomli_w

from haptid.measurement.commands import init as main
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.making.mapping import Target, free_joints, map_columns, parse_map
from haptid.measurement.making.writing import refuse_overwrite, write_table
from haptid.measurement.tables.table import SUFFIXES, Table, read_table
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.support.command import parse_joints
from haptid.support.errors import InputError
from haptid.support.files.files import is_file, write_bytes, write_text


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Hold the user's statements on the data, from flags or from answers to questions.

    Parameters
    ----------
    title
        One line that names the tests.
    device
        Built-in name, device file, or ``single_joint``.
    measured
        False for synthetic data.
    hold
        Torque between rows, ``zero`` or ``linear``.
    noise
        Standard deviation of the white sensor noise [rad] ([m]); None to estimate it.
    resolution
        Encoder step [rad] ([m]); None to estimate it.
    validate
        Names of the tables that validate.
    free
        Joints that move; None for all that have a torque and a position.
    targets
        Column of the format by column of the user's tables.
    """

    title: str
    device: str
    measured: bool
    hold: str
    noise: float | None
    resolution: float | None
    validate: tuple[str, ...]
    free: tuple[int, ...] | None
    targets: Mapping[str, Target]


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
        Folder, title, device and runs of the campaign.
    """
    refuse_overwrite(out)
    tables = _tables(folder)
    answers = _answers(folder, tables, dict(flags), parse_map(maps))
    out.parent.mkdir(parents=True, exist_ok=True)
    # Written and checked beside its place, then moved: a campaign that cannot be read never appears under its name.
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as draft:
        inner = Path(draft) / out.name
        _write(inner, tables, answers)
        with warnings_on_stderr():
            campaign = _check_draft(inner, folder)
        if out.exists():
            out.rmdir()
        shutil.move(inner, out)
    kinds = "; ".join("+".join(map(str, joints)) for joints in campaign.configurations)
    about = f"{len(campaign.runs)} runs, free joints {kinds}, {campaign.label} data, device {campaign.device}"
    click.echo(f"wrote {out}: {about}")
    click.echo(f"next: python -m measurement.check {out}")
    runs = [{"file": run.file, "free_joints": list(run.free_joints), "use": run.use} for run in campaign.runs]
    return {"campaign": str(out), "title": campaign.title, "device": campaign.device, "runs": runs}


def _check_draft(draft: Path, folder: Path) -> Campaign:
    """Read the draft; an error names the user's own tables instead of the draft's."""
    try:
        return read_campaign(draft)
    except InputError as error:
        raise InputError(
            error.where.replace(str(draft), str(folder)), expected=error.expected, got=error.got, todo=error.todo
        ) from None


def _tables(folder: Path) -> list[Table]:
    if not folder.is_dir():
        raise InputError(str(folder), expected="a folder of tables", got="no such folder")
    paths = sorted(path for path in folder.iterdir() if path.name.endswith(SUFFIXES))
    if not paths:
        raise InputError(str(folder), expected=f"tables that end in {', '.join(SUFFIXES)}", got="none")
    return [read_table(path, as_text=True) for path in paths]


def _answers(folder: Path, tables: list[Table], flags: dict[str, Any], targets: dict[str, Target]) -> Answers:
    if _can_ask():
        flags = _ask(folder, tables, flags)
        targets = {**targets, **_ask_columns(tables, targets)}
    names = {table.path.name for table in tables}
    unknown = [name for name in flags["validate"] if name not in names]
    if unknown:
        where = "--validate"
        raise InputError(where, expected=f"one of {', '.join(sorted(names))}", got=unknown[0])
    if flags["measured"] is None:
        where = "--measured or --synthetic"
        raise InputError(where, expected="one of the two flags", got="neither")
    title, device = flags["title"] or folder.resolve().name, flags["device"] or "single_joint"
    free = parse_joints(flags["free"])
    return Answers(**{**flags, "title": title, "device": device, "free": free, "targets": targets})


def _can_ask() -> bool:
    return sys.stdin.isatty()


def _ask(folder: Path, tables: list[Table], flags: dict[str, Any]) -> dict[str, Any]:
    """Ask for title, device, origin and validation runs where no flag gives them."""
    flags = dict(flags)
    if flags["title"] is None:
        flags["title"] = click.prompt("Title", default=folder.resolve().name)
    if flags["device"] is None:
        flags["device"] = click.prompt("Device (built-in name, device TOML, or single_joint)", default="single_joint")
    if flags["measured"] is None:
        flags["measured"] = click.confirm("Were the data measured on a real device?", default=True)
    if not flags["validate"] and len(tables) > 1:
        listed = " ".join(table.path.name for table in tables)
        answer = click.prompt(f"Runs to keep from every fit, of {listed} (separated by spaces)", default="")
        flags["validate"] = tuple(answer.split())
    return flags


def _ask_columns(tables: list[Table], targets: dict[str, Target]) -> dict[str, Target]:
    """Ask for the meaning of each column where the first table has no ``time_s`` or no position."""
    first = tables[0]
    names = {targets[name].name if name in targets else name for name in first.columns}
    if "time_s" in names and any(name.startswith("position_") for name in names):
        return {}
    click.echo(f"{first.path.name} has the columns {', '.join(first.columns)}. Empty keeps a column as it is.")
    entries = []
    for column in first.columns:
        if column not in targets:
            goal = click.prompt(f"{column} is (time_s, torque_0_Nm, position_0_rad*0.0174533, …)", default="")
            entries += [f"{column}={goal}"] if goal else []
    return parse_map(tuple(entries))


def _write(folder: Path, tables: list[Table], answers: Answers) -> None:
    runs: list[dict[str, Any]] = []
    sensor: dict[str, float | None] = {}
    for table in tables:
        frame = map_columns(table, answers.targets)
        joints = free_joints(list(frame.columns), str(table.path), answers.free)
        use = "validate" if table.path.name in answers.validate else "fit"
        runs.append({"file": table.path.name, "free_joints": list(joints), "use": use})
        write_table(folder / table.path.name, frame)
        for unit in ("rad", "m"):
            if any(f"position_{joint}_{unit}" in frame for joint in joints):
                sensor |= {f"noise_{unit}": answers.noise, f"resolution_{unit}": answers.resolution}
    device = _copy_device(answers.device, folder)
    head = {"title": answers.title, "device": device, "measured": answers.measured, "hold": answers.hold}
    known = {key: value for key, value in sensor.items() if value is not None}
    content = {"campaign": head, **({"sensor": known} if known else {}), "runs": runs}
    write_text(folder / "campaign.toml", tomli_w.dumps(content))


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
