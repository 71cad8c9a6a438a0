"""What flags or replies say and the user's tables in, tables of a campaign out, or a refusal of what is not known."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from haptid.measurement.format.devices import SINGLE_JOINT, joint_count
from haptid.measurement.making.answers import Answers, find_device, select_runs
from haptid.measurement.making.prepared import (
    PreparedTable,
    current_constants,
    lack_supply,
    map_currents,
    with_supply,
)
from haptid.measurement.naming.mapping import Target
from haptid.measurement.tables.table import Table
from haptid.support.command import parse_joints
from haptid.support.errors import InputError

EXAMPLE_CONSTANT = 0.4
"""Torque of an ampere [N m/A] that an error shows as an example."""
LINE_ON_CONSTANT = re.compile(
    r"(?<![a-z])(?:k_?[tm]|(?:torque|force|motor)[ _-]?const(?:ant)?)(?![a-z]).*\d", re.IGNORECASE
)
"""A line before a table's header that tells the torque of an ampere."""


def answers_of(
    folder: Path, tables: Sequence[Table], flags: Mapping[str, Any], stated: Mapping[str, Target]
) -> Answers:
    """Check what flags or replies say.

    Parameters
    ----------
    folder
        Folder of the tables.
    tables
        The user's tables.
    flags
        Options of ``haptid init`` by name; None, or empty, where absent.
    stated
        Column of the format by column of the user's tables, as the user states it.

    Returns
    -------
    Answers

    Raises
    ------
    InputError
        Where a number is none that a motor or a sensor has, or no device or run has the stated name.
    """
    _check_numbers(flags)
    return Answers(
        title=flags["title"] or folder.resolve().name,
        device=find_device(flags["device"] or SINGLE_JOINT, folder),
        measured=bool(flags["measured"]),
        hold=flags["hold"],
        noise=flags["noise"],
        resolution=flags["resolution"],
        validate=select_runs(flags["validate"], [table.file_name for table in tables]),
        free=parse_joints(flags["free"], "--free"),
        stated=stated,
        torque_constant=flags["torque_constant"],
        resistance=flags["resistance"],
        supply=flags["supply"],
    )


def complete(prepared: list[PreparedTable], answers: Answers) -> list[PreparedTable]:
    """Complete tables by what is stated of their drives.

    Parameters
    ----------
    prepared
        All tables.
    answers
        What the user states.

    Returns
    -------
    list of PreparedTable
        The tables; where a duty was recorded, with its supply.

    Raises
    ------
    InputError
        Where the device lacks a joint or joints move together without one, a duty lacks its supply, or a current the
        torque of an ampere.
    """
    completed = _with_supply(prepared, answers.supply)
    _refuse_joints_together(completed, str(answers.device))
    _refuse_absent_joints(completed, str(answers.device))
    _refuse_bare_current(completed, answers)
    return completed


def _check_numbers(flags: Mapping[str, Any]) -> None:
    """Refuse numbers that no motor and no sensor has."""
    constant = flags["torque_constant"]
    if constant is not None and not 0.0 < abs(constant) < float("inf"):
        raise InputError("--torque-constant", expected="a number of N m/A or N/A, not 0", got=f"{constant:g}")
    if flags["resistance"] is not None and not 0.0 < flags["resistance"] < float("inf"):
        raise InputError("--resistance", expected="a number of ohms above 0", got=f"{flags['resistance']:g}")
    if flags["supply"] is not None and not 0.0 < flags["supply"] < float("inf"):
        raise InputError("--supply", expected="a number of volts above 0", got=f"{flags['supply']:g}")
    for name in ("noise", "resolution"):
        if flags[name] is not None and not 0.0 <= flags[name] < float("inf"):
            where = f"--{name}"
            raise InputError(where, expected="a number of rad, at least 0", got=f"{flags[name]:g}")


def _refuse_bare_current(prepared: Sequence[PreparedTable], answers: Answers) -> None:
    """Refuse a current that was recorded in place of a torque, where the torque of an ampere is not stated."""
    keys = current_constants(prepared)
    if answers.torque_constant is not None or not keys:
        return
    (joint, key), *_ = keys.items()
    unit = "N/A" if key.startswith("force") else "N m/A"
    todo = f"state it by --torque-constant [{unit}]; 1 where nobody knows it: masses and friction are then in amperes"
    if len(keys) > 1:
        # Two show how: the options of six joints would be cut within a name.
        own = " ".join([*map_currents(prepared, EXAMPLE_CONSTANT).values()][:2])
        todo = f"state it by --torque-constant [{unit}] where it is that of all motors, or each by {own}"
    where = f"current_{joint}_A"
    got = f"a current alone{_told_constant(prepared)}"
    raise InputError(where, expected="the torque of an ampere", got=got, todo=todo)


def _told_constant(prepared: Sequence[PreparedTable]) -> str:
    """Return what a line of a logger says of the torque of an ampere: its unit is the user's to know."""
    lines = ((one.file, line.strip("#%;, \t")) for one in prepared for line in one.source.preamble)
    said = next(((file, line) for file, line in lines if LINE_ON_CONSTANT.search(line)), None)
    return "" if said is None else f" ({said[0]} says {said[1]!r})"


def _with_supply(prepared: list[PreparedTable], volts: float | None) -> list[PreparedTable]:
    """Return the tables with the stated supply, where a duty was recorded without one."""
    lacking = lack_supply(prepared)
    if volts is not None and not lacking:
        got = "tables that hold their supply, or no duty"
        raise InputError("--supply", expected="a duty without a column supply_V", got=got, todo="leave it out")
    if not lacking:
        return prepared
    if volts is None:
        todo = (
            "state the voltage of the motor's amplifier by --supply [V], or name its column by --map 'COLUMN=supply_V'"
        )
        raise InputError(lacking[0], expected="the supply of which a duty is a share", got="a duty alone", todo=todo)
    return with_supply(prepared, volts)


def _refuse_joints_together(prepared: Sequence[PreparedTable], device: str) -> None:
    """Refuse joints that move together where no device says how they are linked."""
    together = next((one for one in prepared if len(one.free) > 1), None)
    if device == SINGLE_JOINT and together is not None:
        got = f"joints {', '.join(map(str, together.free))} that move together"
        todo = f"--device says how they are linked (a URDF, say); --free {together.free[0]} takes one of them alone"
        raise InputError(together.file, expected="one joint that moves, or a device", got=got, todo=todo)


def _refuse_absent_joints(prepared: Sequence[PreparedTable], device: str) -> None:
    """Refuse joints that the device lacks, in words of the user's own columns."""
    count = joint_count(device)
    if count is None:
        return
    for one in prepared:
        absent = [joint for joint in one.free if joint >= count]
        if absent:
            name = Path(device).name
            columns = [column for column, target in one.targets.items() if target.name == f"position_{absent[0]}_rad"]
            got = f"joint {absent[0]}" + (f" of column {columns[0]!r}" if columns else "")
            column = columns[0] if columns else "q"
            factor = one.targets[column].factor if columns else 1.0
            target = f"position_{count - 1}_rad" + (f"*{factor:.6g}" if factor != 1.0 else "")
            todo = f"name the joint by --map '{column}={target}', or another --device"
            raise InputError(one.file, expected=f"joints 0 to {count - 1} of {name}", got=got, todo=todo)
