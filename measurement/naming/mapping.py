"""Rename and rescale the columns of a table to those of the campaign format: `Table` in, data frame out."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from haptid.measurement.format.columns import JOINT, KNOWN
from haptid.measurement.naming.lacking_columns import find_followed, tell_how_to_name
from haptid.measurement.naming.signal_names import holds_likely, is_prismatic_joint, silent_columns
from haptid.measurement.tables.table import Table
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

TORQUE = re.compile(
    rf"(?:torque_({JOINT})_Nm|force_({JOINT})_N|current_({JOINT})_A|voltage_({JOINT})_V|duty_({JOINT}))"
)
"""Columns that drive a joint; one of the groups is its number."""
FLAG = "--map"
REFERENCE = re.compile(rf"reference_({JOINT})_(?:rad|m)")
"""Columns that tell a joint's controller where to go; the group is the joint's number."""
POSITION = re.compile(rf"position_({JOINT})_(?:rad|m)")
"""Columns with the position of a joint; the group is its number."""

SHARE_OF_TORQUE = re.compile(
    r"(?=.*(?:torque|tau|effort|moment))(?=.*(?P<mille>‰|0[.,]1 ?%|per ?mil)|.*(?:%|per ?cent))", re.IGNORECASE
)
"""Names of a torque in per cent or, as drives by CiA 402 have it, in per mille of the rated one."""
COLUMNS_NEEDED = "columns time_s, torque_<j>_Nm, position_<j>_rad"
"""What an error expects of a table that lacks a signal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Name a column of the campaign format.

    Parameters
    ----------
    name
        As ``position_0_rad``.
    factor
        Number in the unit of ``name`` per number of the user's column.
    """

    name: str
    factor: float = 1.0


def map_columns(table: Table, targets: Mapping[str, Target]) -> pd.DataFrame:
    """Rename the mapped columns and multiply them by their factors.

    Parameters
    ----------
    table
        The user's table.
    targets
        Column of the format by column of the table, as `parse_map` returns it.

    Returns
    -------
    DataFrame
        All columns of the table. Columns with factor 1 keep their cells as they are written.

    Raises
    ------
    InputError
        Where the table lacks a mapped column, a cell to be scaled is no number, or two columns get the same name.
    """
    missing = [column for column in targets if column not in table.columns]
    if missing:
        got = ", ".join(table.columns)
        raise InputError(table.header, expected=f"a column {missing[0]} (named in --map)", got=got)
    scaled = {column: target.factor * table.numbers(column) for column, target in targets.items() if target.factor != 1}
    renamed = table.frame.assign(**scaled).rename(columns={column: target.name for column, target in targets.items()})
    doubled = renamed.columns[renamed.columns.duplicated()]
    if len(doubled):
        raise InputError(table.header, expected=f"one column {doubled[0]} after --map", got="two")
    return renamed


def _refuse_share_of_torque(columns: Sequence[str], file: str) -> None:
    """Refuse a torque in per cent of the rated one, as servo drives give it: only the user knows the rated torque."""
    for name in columns:
        found = SHARE_OF_TORQUE.search(name)
        if found and not KNOWN.fullmatch(name):
            number = re.search(rf"(?<!\d){JOINT}(?!\d)", name)
            joint = int(number.group()) if number else 0
            part, factor = ("thousandth", 1e-3) if found["mille"] else ("hundredth", 1e-2)
            # A joint that slides has a force: a factor to N m would be refused by the reader of the campaign.
            goal, unit, rated, word = (
                (f"force_{joint}_N", "N", 240.0, "force")
                if is_prismatic_joint(joint, columns)
                else (f"torque_{joint}_Nm", "N m", 2.4, "torque")
            )
            option = f"--map '{name}={goal}*{factor * rated:.4g}'"
            todo = f"state a {part} of the rated {word}: {option} where it is {rated:g} {unit}"
            raise InputError(file, expected=f"a {word} in {unit}", got=f"{name!r}", todo=todo)


def free_joints(
    columns: list[str],
    file: str,
    only: tuple[int, ...] | None = None,
    closed: frozenset[int] = frozenset(),
    numbers_of: Callable[[str], Array] | None = None,
) -> tuple[int, ...]:
    """Return the free joints of a table: those with both a torque (or what drives the motor) and a position.

    Parameters
    ----------
    columns
        Names of the columns in the campaign format.
    file
        Name of the table, for errors.
    only
        Joints to choose from; None for all.
    closed
        Joints whose controller is known: what it follows drives them as well.
    numbers_of
        Function from a column to its numbers, by which an error chooses a unit that no name tells; None where they are
        not known.

    Returns
    -------
    tuple of int
        Joint numbers, ascending, at least one.

    Raises
    ------
    InputError
        Where no such joint or no ``time_s`` is there.
    """
    driven = _driven_joints(columns, closed)
    seen = {int(found.group(1)) for name in columns if (found := POSITION.fullmatch(name))}
    found_joints = driven & seen if only is None else driven & seen & set(only)
    if not found_joints or "time_s" not in columns:
        if not driven:
            _refuse_share_of_torque(columns, file)
            refuse_reference_alone(columns, file, numbers_of)
        lacking = lacking_signals(columns, closed)
        todo = (
            tell_how_to_name(lacking, columns, driven | seen, numbers_of)
            if lacking
            else _which_joints(driven, seen, only)
        )
        raise InputError(file, expected=COLUMNS_NEEDED, got=", ".join(columns), todo=todo)
    return tuple(sorted(found_joints))


def lacking_signals(columns: Sequence[str], closed: frozenset[int] = frozenset()) -> list[str]:
    """Find the signals that a table lacks for a fit.

    Parameters
    ----------
    columns
        Names of the columns in the campaign format.
    closed
        Joints whose controller is known.

    Returns
    -------
    list of str
        Of ``time``, ``torque`` (anything that drives a joint) and ``position``, in this order.
    """
    driven, seen = _driven_joints(columns, closed), any(POSITION.fullmatch(name) for name in columns)
    parts = (("time_s" in columns, "time"), (bool(driven), "torque"), (seen, "position"))
    return [word for there, word in parts if not there]


def _driven_joints(columns: Sequence[str], closed: frozenset[int]) -> set[int]:
    """Return the joints whose torque, or what makes it, a table holds."""
    driven = {int(next(filter(None, found.groups()))) for name in columns if (found := TORQUE.fullmatch(name))}
    return driven | closed & {int(found.group(1)) for name in columns if (found := REFERENCE.fullmatch(name))}


def refuse_reference_alone(columns: Sequence[str], file: str, numbers_of: Callable[[str], Array] | None = None) -> None:
    """Refuse a position beside what it is to follow, as state and action of a robot's data set, and nothing else.

    Parameters
    ----------
    columns
        Names of the columns, in the campaign format where they are known.
    file
        Name of the table, for errors.
    numbers_of
        As `free_joints` takes it.

    Raises
    ------
    InputError
        Where no column drives a joint, or may do so, and there is a position with its reference.
    """
    position, reference = find_followed(columns, numbers_of)
    is_named = POSITION.fullmatch(position) is not None and REFERENCE.fullmatch(reference) is not None
    if not reference or holds_likely("torque", columns) or any(TORQUE.fullmatch(name) for name in columns):
        return
    # Where the user has named both, what is left is not meant to be used.
    if not is_named and silent_columns(columns):
        return
    joint = int(found.group(1)) if (found := POSITION.fullmatch(position)) else 0
    todo = (
        f"log one of them too, or state the position controller: [joint.{joint}.controller] in a campaign.toml, "
        "or joints= of Campaign.from_frames"
    )
    got = "its position and reference alone" if is_named else f"{position} and its target {reference} alone"
    raise InputError(file, expected=f"torque, current, voltage or duty of joint {joint}", got=got, todo=todo)


def _which_joints(driven: Collection[int], seen: Collection[int], only: tuple[int, ...] | None) -> str:
    torques, positions = (", ".join(map(str, sorted(joints))) for joints in (driven, seen))
    alone = "" if only is None else f", free are to be {', '.join(map(str, only))} alone"
    return (
        f"no torque and position of one joint: torques of {torques}, positions of {positions}{alone}; "
        "give both one number by --map"
    )
