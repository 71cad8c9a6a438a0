"""Rename and rescale the columns of somebody's table to those of the campaign format."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from haptid.measurement.format.columns import KNOWN
from haptid.measurement.format.table import Table
from haptid.support.errors import InputError

TORQUE = re.compile(r"(?:torque_(\d+)_Nm|force_(\d+)_N|current_(\d+)_A)")
FLAG = "--map"
POSITION = re.compile(r"position_(\d+)_(?:rad|m)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A column of the format: name, and the factor to its unit."""

    name: str
    factor: float = 1.0


def parse_map(entries: tuple[str, ...]) -> dict[str, Target]:
    """Read ``COLUMN=NAME`` or ``COLUMN=NAME*FACTOR``, as in ``angle_deg=position_0_rad*0.017453292519943295``."""
    targets: dict[str, Target] = {}
    for entry in entries:
        column, _, goal = entry.rpartition("=")
        name, _, factor = goal.partition("*")
        if not column or not KNOWN.fullmatch(name):
            expected = "COLUMN=NAME or COLUMN=NAME*FACTOR with a NAME such as torque_0_Nm or position_0_rad"
            raise InputError(FLAG, expected=expected, got=repr(entry))
        try:
            targets[column] = Target(name=name, factor=float(factor or 1))
        except ValueError:
            raise InputError(FLAG, expected=f"a number as the factor of {name}", got=repr(factor)) from None
    return targets


def map_columns(table: Table, targets: Mapping[str, Target]) -> pd.DataFrame:
    """Return the table with the mapped columns renamed and multiplied by their factors."""
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


def free_joints(columns: list[str], file: str, only: tuple[int, ...] | None = None) -> tuple[int, ...]:
    """Tell the free joints: those that have both a torque (force, current) and a position, and are among ``only``."""
    driven = {int(next(filter(None, found.groups()))) for name in columns if (found := TORQUE.fullmatch(name))}
    seen = {int(found.group(1)) for name in columns if (found := POSITION.fullmatch(name))}
    found_joints = driven & seen if only is None else driven & seen & set(only)
    if not found_joints or "time_s" not in columns:
        todo = "name them with --map, as in --map 'tau=torque_0_Nm'"
        raise InputError(
            file, expected="columns time_s, torque_<j>_Nm, position_<j>_rad", got=", ".join(columns), todo=todo
        )
    return tuple(sorted(found_joints))
