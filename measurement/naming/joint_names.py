"""Columns by the names of the device's joints: ``elbow torque (Nm)`` of an arm in, ``torque_1_Nm`` out."""

from __future__ import annotations

import re
from collections.abc import Mapping

from haptid.measurement.format.columns import KNOWN, NUMBERED
from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.switches import understand_switches
from haptid.measurement.naming.units_in_names import understand_column, understand_columns
from haptid.measurement.tables.table import Table
from haptid.model.device.device import Device


def numbers_by_name(device: Device) -> dict[str, int]:
    """Return the number of each joint of the device by its name, longest names first.

    Parameters
    ----------
    device
        Device.

    Returns
    -------
    dict
    """
    found = {joint.name: number for number, joint in enumerate(device.joints)}
    return dict(sorted(found.items(), key=lambda pair: -len(pair[0])))


def joint_named_in(column: str, numbers: Mapping[str, int]) -> tuple[int | None, str]:
    """Find the joint that a column's name names.

    Parameters
    ----------
    column
        Name of a column.
    numbers
        Number of each joint by its name, as `numbers_by_name` returns them.

    Returns
    -------
    number, numbered : int or None, str
        Number of the joint, None where no name is there, and the column's name with the number for the joint's name.
    """
    for name, number in numbers.items():
        word = rf"(?<![^\W_]){re.escape(name)}(?![^\W_])"
        changed = re.sub(word, f"joint{number}", column, count=1, flags=re.IGNORECASE)
        if changed != column:
            return number, changed
    return None, column


def understand_table(
    table: Table, stated: Mapping[str, Target], resolution: float | None, numbers: Mapping[str, int]
) -> dict[str, Target]:
    """Return what the columns of a table stand for, with the names of the device's joints for their numbers.

    Parameters
    ----------
    table
        The user's table.
    stated
        What the user says of columns; it overrules their names.
    resolution
        Size of one encoder count [rad] or [m]; None where it is not stated.
    numbers
        As `joint_named_in` takes them.

    Returns
    -------
    dict
        Column of the format by the user's column, as `understand_columns` returns it.

    Raises
    ------
    InputError
        As `understand_columns`.
    """

    def numbered(column: str) -> str:
        if column in stated or KNOWN.fullmatch(column) or understand_column(column, 1.0) is not None:
            return column
        return joint_named_in(column, numbers)[1]

    columns = {numbered(column): column for column in table.columns}
    if len(columns) < len(table.columns):  # two names of one joint: none is taken for a number
        columns = {column: column for column in table.columns}
    targets = understand_columns(list(columns), stated, resolution)
    of_names = {columns.get(column, column): target for column, target in targets.items()}
    return understand_switches(table, stated) | of_names | _by_joints(table, stated, numbers)


def _by_joints(table: Table, stated: Mapping[str, Target], numbers: Mapping[str, int]) -> dict[str, Target]:
    """Return what the columns of a recording stand for whose joints have the names of the device's.

    A joint that the device does not have, as a gripper's, is left unused.
    """
    if not set(table.joints) & set(numbers):
        return {}
    found = {}
    for column in table.columns:
        number = NUMBERED.search(column) if column not in stated and KNOWN.fullmatch(column) else None
        name = table.joints[int(number[1])] if number is not None else ""
        if number is not None and name in numbers:
            found[column] = Target(name=NUMBERED.sub(f"_{numbers[name]}", column))
        elif number is not None:
            found[column] = Target(name=f"{name} {column}")
    return {column: target for column, target in found.items() if target.name != column}
