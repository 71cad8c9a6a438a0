"""A table made ready for a campaign: `Table` and `Answers` in, columns of the format, free joints and posture out."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from haptid.measurement.format.columns import KNOWN, NUMBERED
from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.making.answers import Answers, device_of
from haptid.measurement.making.moving_joints import moving_joints
from haptid.measurement.making.times import with_counter_counted_on
from haptid.measurement.making.usable_rows import (
    UsableTable,
    counted_on,
    cut_at_gaps,
    usable_rows,
    without_shared_rows,
)
from haptid.measurement.naming.joint_names import numbers_by_name, understand_table
from haptid.measurement.naming.lacking_columns import travel_alike
from haptid.measurement.naming.mapping import POSITION, REFERENCE, Target, free_joints, map_columns
from haptid.measurement.naming.signal_names import is_bare_demand
from haptid.measurement.tables.table import Table
from haptid.measurement.values.postures import median_postures
from haptid.measurement.values.run import Array
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device

TORQUE_COLUMNS = ("torque_{}_Nm", "force_{}_N", "current_{}_A")
DRIVE_COLUMNS = {"voltage": "voltage_{}_V", "duty": "duty_{}"}
"""Column by the kind of a drive that makes the torque."""
SUPPLY = "supply_V"
DECIMALS_OF_POSTURE = 6
"""Decimals of a locked position in campaign.toml: a microradian changes no inertia that can be measured."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PreparedTable:
    """A table in the campaign format.

    Parameters
    ----------
    file
        Name of the table.
    frame
        Its columns by their names in the format; others as they are.
    targets
        Column of the format by the user's column, where name or unit changed.
    free
        Joints that move.
    held
        Joints that have a torque and a position, and do not move.
    posture
        Positions of the device's joints [rad] ([m]) while they are locked, 0 for the free ones; empty for a single
        joint.
    use
        ``fit`` or ``validate``.
    t
        Times [s], shape (n_t,).
    travels
        Travel of each free joint [rad] ([m]).
    source
        The table that it was made of, which knows the places of its rows in the user's file.
    about
        What was done to its rows, in words for the user.
    """

    file: str
    frame: pd.DataFrame
    targets: dict[str, Target]
    free: tuple[int, ...]
    held: tuple[int, ...]
    posture: tuple[float, ...]
    use: str
    t: Array
    travels: tuple[float, ...]
    source: Table
    about: tuple[str, ...] = ()


def prepare_tables(tables: Sequence[Table], answers: Answers, *, mend: bool = True) -> list[PreparedTable]:
    """Bring the tables of a campaign into its format, and see which joints move.

    Parameters
    ----------
    tables
        The user's tables, their cells as text or as numbers.
    answers
        What the user states.
    mend
        Whether rows that cannot be used are left out. A program's rows are all used, or refused.

    Returns
    -------
    list of PreparedTable
        One a table, or several where rows are missing in it. Positions are counted on where they wrap.

    Raises
    ------
    InputError
        Where columns are missing or stand for the same signal, or a cell of time or position holds no number.
    """
    device = device_of(answers)
    numbers = {} if device is None else numbers_by_name(device)
    everywhere = {column for table in tables for column in table.columns}
    understood = []
    for table in tables:
        # Tables of different joints have different columns; one that no table has is a slip, and refused below.
        stated = {c: goal for c, goal in answers.stated.items() if c in table.columns or c not in everywhere}
        understood.append(understand_table(table, stated, answers.resolution, numbers))
    understood = _counted_from_zero(tables, understood, answers, device)
    if device is None:
        understood = [_in_one_joint(table, targets, answers) for table, targets in zip(tables, understood, strict=True)]
    named = [
        _name_columns(table, targets, answers, mend=mend) for table, targets in zip(tables, understood, strict=True)
    ]
    taken = {table.file_name for table in tables}
    prepared = []
    for table, targets, usable in zip(tables, understood, without_shared_rows(named) if mend else named, strict=True):
        use = "validate" if table.file_name in answers.validate else "fit"
        for part in cut_at_gaps(_count_on(usable, answers), taken):
            taken.add(part.table.file_name)
            # Once more: across a gap a joint may turn so far that no jump of the whole run tells of a wrap.
            prepared.append(_prepare(_count_on(part, answers), targets, answers, use=use))
    return prepared


def _count_on(usable: UsableTable, answers: Answers) -> UsableTable:
    return counted_on(usable, _position_names(usable.table), answers.resolution)


def _counted_from_zero(
    tables: Sequence[Table], understood: list[dict[str, Target]], answers: Answers, device: Device | None
) -> list[dict[str, Target]]:
    """Return the targets with joints from 0 where the tables count the device's joints from 1.

    They do where no table has a joint 0 and one has the number that would be the device's last but one more. A column
    without a number, as a temperature of the whole device, is taken for joint 0 and says nothing of the count.
    """
    if device is None or answers.stated or answers.free is not None or answers.closed:
        return understood
    names = [{**{c: c for c in table.columns if KNOWN.fullmatch(c)}, **{c: t.name for c, t in targets.items()}}
             for table, targets in zip(tables, understood, strict=True)]  # fmt: skip
    names = [{c: name for c, name in one.items() if re.search(r"\d", c) or c == name} for one in names]
    numbers = {int(found.group(1)) for one in names for name in one.values() if (found := NUMBERED.search(name))}
    if 0 in numbers or max(numbers, default=0) != len(device.joints):
        return understood
    shifted = []
    for one, targets in zip(names, understood, strict=True):
        lower = {
            column: NUMBERED.sub(lambda found: f"_{int(found.group(1)) - 1}", name) for column, name in one.items()
        }
        factors = {column: target.factor for column, target in targets.items()}
        moved = {c: Target(name=name, factor=factors.get(c, 1.0)) for c, name in lower.items() if name != c}
        shifted.append({c: target for c, target in targets.items() if c not in one} | moved)
    return shifted


def _in_one_joint(table: Table, targets: dict[str, Target], answers: Answers) -> dict[str, Target]:
    """Give columns without a number that of the others, where these are of one joint: ``Axis 1 [°]`` and ``Torque``."""
    joints = {column: int(found[1]) for column, one in targets.items() if (found := NUMBERED.search(one.name))}
    plain = [column for column in joints if not re.search(r"\d", column) and column not in answers.stated]
    told = {joint for column, joint in joints.items() if column not in plain}
    if not plain or len(told) != 1 or any(NUMBERED.search(column) for column in table.columns):
        return targets
    (joint,) = told
    moved = {column: replace(targets[column], name=NUMBERED.sub(f"_{joint}", targets[column].name)) for column in plain}
    taken = {one.name for column, one in targets.items() if column not in plain}
    return targets if any(one.name in taken for one in moved.values()) else targets | moved


def _name_columns(table: Table, targets: dict[str, Target], answers: Answers, *, mend: bool) -> UsableTable:
    """Return a table with the columns of the campaign format and without rows that cannot be used."""
    table, counted = with_counter_counted_on(table, targets)
    names = {column: targets[column].name if column in targets else column for column in table.columns}
    needed = [column for column, name in names.items() if _is_needed(name)]
    time = next((column for column, name in names.items() if name == "time_s"), "time_s")
    commands = (*TORQUE_COLUMNS, *DRIVE_COLUMNS.values()) if answers.hold == "zero" else ()
    held = [column for column, name in names.items() if NUMBERED.sub("_{}", name) in commands]
    usable = usable_rows(table, needed if mend else (), time, held)
    frame = map_columns(usable.table, targets)
    free_joints(list(frame.columns), str(table.path), answers.free, answers.closed, table.loosely)
    about = (*usable.about, *([counted] if counted else []))
    return replace(usable, table=replace(usable.table, frame=frame), about=about)


def _position_names(table: Table) -> list[str]:
    return [name for name in table.columns if POSITION.fullmatch(name) or REFERENCE.fullmatch(name)]


def _is_needed(name: str) -> bool:
    """Whether a run cannot do without the cells of a column; a temperature may be read more seldom."""
    return KNOWN.fullmatch(name) is not None and not name.startswith("temperature")


def _prepare(usable: UsableTable, targets: dict[str, Target], answers: Answers, *, use: str) -> PreparedTable:
    """Return the table of one run, with the joints that move in it."""
    table, frame = usable.table, usable.table.frame
    driven = free_joints(list(frame.columns), str(table.path), answers.free, answers.closed)
    t = table.time()
    names = [name for name in table.columns if POSITION.fullmatch(name)]
    positions = {name: table.numbers(name) for name in names}
    free = driven if answers.free is not None else moving_joints(t, positions, driven)
    everything = free_joints(list(frame.columns), str(table.path), closed=answers.closed)
    return PreparedTable(
        file=table.file_name,
        frame=frame,
        targets=targets,
        free=free,
        held=tuple(joint for joint in everything if joint not in free),
        posture=_posture(answers.device, positions, free),
        use=use,
        t=t,
        travels=tuple(_travel(positions, joint) for joint in free),
        source=table,
        about=usable.about,
    )


def _travel(positions: dict[str, Array], joint: int) -> float:
    """Return the travel of a joint; one with positions in rad and in m is refused when the campaign is read."""
    values = next(positions[name] for name in (f"position_{joint}_rad", f"position_{joint}_m") if name in positions)
    return float(np.ptp(values))


def _posture(device: str | Device, positions: dict[str, Array], free: Sequence[int]) -> tuple[float, ...]:
    """Return the positions at which the joints were locked, as far as the table has them."""
    if device == SINGLE_JOINT:
        return ()
    loaded = device if isinstance(device, Device) else load_device(device)
    posture = [0.0] * len(loaded.joints)
    for name, values in positions.items():
        found = POSITION.fullmatch(name)
        joint = int(found.group(1)) if found else len(posture)
        if joint < len(posture) and joint not in free:
            posture[joint] = round(float(np.median(values)), DECIMALS_OF_POSTURE) + 0.0
    return tuple(posture)


def describe_campaign(prepared: Sequence[PreparedTable], answers: Answers, device: str) -> dict[str, Any]:
    """Return the content of ``campaign.toml`` for prepared tables.

    Parameters
    ----------
    prepared
        All tables.
    answers
        What the user states.
    device
        Name of the device in the campaign.

    Returns
    -------
    dict
        Tables ``campaign``, ``sensor`` (where something is stated), ``joint`` (where a drive was recorded), ``runs``.
    """
    runs: list[dict[str, Any]] = []
    sensor: dict[str, float | None] = {}
    held = [np.array(one.posture) for one in prepared]
    for one, joined in zip(prepared, median_postures([one.free for one in prepared], held, {}), strict=True):
        posture = {"locked_positions_rad": np.round(joined, DECIMALS_OF_POSTURE).tolist()} if joined.any() else {}
        runs.append({"file": one.file, "free_joints": list(one.free), **posture, "use": one.use})
        for unit in ("rad", "m"):
            if any(f"position_{joint}_{unit}" in one.frame for joint in one.free):
                sensor |= {f"noise_{unit}": answers.noise, f"resolution_{unit}": answers.resolution}
    head = {"title": answers.title, "device": device, "measured": answers.measured, "hold": answers.hold}
    known = {key: value for key, value in sensor.items() if value is not None}
    known_of_drive = {"torque_constant": answers.torque_constant, "resistance_ohm": answers.resistance}
    motor = {key: value for key, value in known_of_drive.items() if value is not None}
    joints: dict[str, Any] = {
        str(j): {"drive": {"kind": kind, **motor}} for j, kind in sorted(_drives(prepared).items())
    }
    if answers.torque_constant is not None:
        keys = current_constants(prepared)
        joints |= {str(joint): {key: answers.torque_constant} for joint, key in sorted(keys.items())}
    return {
        "campaign": head,
        **({"sensor": known} if known else {}),
        **({"joint": joints} if joints else {}),
        "runs": runs,
    }


def current_constants(prepared: Sequence[PreparedTable]) -> dict[int, str]:
    """Find the joints whose current was recorded in place of their torque.

    Parameters
    ----------
    prepared
        All tables.

    Returns
    -------
    dict
        Key of the campaign that states the torque of an ampere, by joint.
    """
    found: dict[int, str] = {}
    for one in prepared:
        for joint in one.free:
            given = [form.format(joint) in one.frame for form in TORQUE_COLUMNS]
            if given == [False, False, True]:
                slides = f"position_{joint}_m" in one.frame
                found[joint] = "force_constant_N_per_A" if slides else "torque_constant_Nm_per_A"
    return found


def map_currents(prepared: Sequence[PreparedTable], constant: float) -> dict[int, str]:
    """Word the option by which a joint's current gets a torque of an ampere of its own.

    Parameters
    ----------
    prepared
        All tables.
    constant
        Torque of an ampere [N m/A] ([N/A]) to show.

    Returns
    -------
    dict
        ``--map 'I1 (A)=torque_1_Nm*0.4'`` by joint, for the joints whose current was recorded in place of their torque.
    """
    words: dict[int, str] = {}
    for joint, key in sorted(current_constants(prepared).items()):
        current = f"current_{joint}_A"
        torque = f"force_{joint}_N" if key.startswith("force") else f"torque_{joint}_Nm"
        # The user's own name and unit of the column, where they are others.
        named = [pair for one in prepared for pair in one.targets.items() if pair[1].name == current]
        column, factor = (named[0][0], named[0][1].factor) if named else (current, 1.0)
        words[joint] = f"--map '{column}={torque}*{factor * constant:.6g}'"
    return words


def _drives(prepared: Sequence[PreparedTable]) -> dict[int, str]:
    """Return the kind of drive of the joints whose voltage or duty was recorded, and no torque."""
    found: dict[int, str] = {}
    for one in prepared:
        for joint in one.free:
            if any(form.format(joint) in one.frame for form in TORQUE_COLUMNS):
                continue
            for kind, form in DRIVE_COLUMNS.items():
                if form.format(joint) in one.frame:
                    found[joint] = kind
    return found


def lack_supply(prepared: Sequence[PreparedTable]) -> list[str]:
    """Find the tables with a duty that do not say of which voltage it is a share.

    Parameters
    ----------
    prepared
        All tables.

    Returns
    -------
    list of str
        Names of the tables.
    """
    return [one.file for one in prepared if "duty" in _drives([one]).values() and SUPPLY not in one.frame]


def with_supply(prepared: Sequence[PreparedTable], volts: float) -> list[PreparedTable]:
    """Write a constant supply into the tables that lack one.

    Parameters
    ----------
    prepared
        All tables.
    volts
        Supply of the drives [V].

    Returns
    -------
    list of PreparedTable
    """
    lacking = lack_supply(prepared)
    return [replace(one, frame=one.frame.assign(**{SUPPLY: volts})) if one.file in lacking else one for one in prepared]


def describe(prepared: Sequence[PreparedTable]) -> list[str]:
    """Say what was understood of the tables: a line a column, then a line a table.

    Parameters
    ----------
    prepared
        All tables.

    Returns
    -------
    list of str
        Lines without line breaks.
    """
    lines: dict[str, None] = {}  # in order, each once
    left: dict[str, None] = {}
    for one in prepared:
        for column, target in one.targets.items():
            if target == Target(name=column):  # the user's word that the column is not to be understood
                continue
            factor = "" if target.factor == 1 else f", × {target.factor:.6g}"
            lines[f"  {column} is {target.name}{factor}"] = None
        left |= dict.fromkeys(_describe_demands(one))
    return [
        *(["understood:", *lines] if lines else []),
        *left,
        "runs:",
        *(f"  {_describe_run(one)}" for one in prepared),
    ]


def _describe_demands(one: PreparedTable) -> list[str]:
    """Say of columns such as ``setpoint`` how they are named, where they may be what the only position follows."""
    positions = [name for name in one.frame.columns if POSITION.fullmatch(name)]
    if len(positions) != 1:
        return []
    (position,) = positions
    reference = position.replace("position", "reference")
    factor = next((target.factor for target in one.targets.values() if target.name == position), 1.0)
    measured = pd.to_numeric(one.frame[position], errors="coerce").to_numpy(dtype=float) / factor
    told = []
    for column in one.frame.columns:
        if reference in one.frame or not is_bare_demand(column):
            continue
        demanded = pd.to_numeric(one.frame[column], errors="coerce").to_numpy(dtype=float)
        if travel_alike(demanded, measured):
            option = f"--map '{column}={reference}" + ("" if factor == 1.0 else f"*{factor:.6g}") + "'"
            told.append(f"not used: {column}; where it is what the position is to follow, name it by {option}")
    return told


def describe_drives(prepared: Sequence[PreparedTable], answers: Answers) -> list[str]:
    """Say of drives what has to be known of them before anything is known in N m.

    Parameters
    ----------
    prepared
        All tables.
    answers
        What the user states.

    Returns
    -------
    list of str
        A line a joint with a voltage or a duty of which torque constant or resistance are not stated.
    """
    unknown = {"torque constant": answers.torque_constant, "resistance": answers.resistance}
    missing = " and ".join(name for name, value in unknown.items() if value is None)
    return [
        f"joint {joint}: a {kind} without {missing} of the motor: masses and friction are known up to one common "
        "factor; state them by --torque-constant and --resistance, or a known gravity in campaign.toml"
        for joint, kind in sorted(_drives(prepared).items())
        if missing
    ]


def _describe_run(one: PreparedTable) -> str:
    slides = [f"position_{joint}_m" in one.frame for joint in one.free]
    moved = ", ".join(
        f"joint {joint} moves by {travel:.3g} {'m' if metres else 'rad'}"
        for joint, travel, metres in zip(one.free, one.travels, slides, strict=True)
    )
    held = f"; held: {', '.join(map(str, one.held))}" if one.held else ""
    rate = 1 / float(np.median(np.diff(one.t)))
    done = f"; {', '.join(one.about)}" if one.about else ""
    return f"{one.file}: {one.use}, {one.t.size} rows, {np.ptp(one.t):.4g} s at {rate:.4g} Hz; {moved}{held}{done}"
