"""Pick the columns of a joint's drive: `Table` and `StatedDrive` in, `DriveColumns` out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.format.drives import StatedDrive
from haptid.measurement.tables.misnamed import advice
from haptid.measurement.tables.table import Table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.joint.drive_terms import (
    ENABLED,
    GAIN,
    REFERENCE,
    SUPPLY,
    drive_inputs,
    drive_quantities,
    torque_along,
)
from haptid.support.errors import InputError

COMMANDS = {"current": "current_{joint}_A", "voltage": "voltage_{joint}_V", "duty": "duty_{joint}"}
"""Column of the command by kind of drive; that of a torque depends on the joint."""
LARGEST_DUTY = 1.0
"""Largest magnitude of a duty: more of them are percent or counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveColumns:
    """Hold what a table states of a joint's drive.

    Parameters
    ----------
    names
        Columns that were used.
    torque
        Torque at the stated parameters of the drive [N m] ([N]), shape (n_t,).
    inputs
        Inputs of the joint's equation by id, shape (n_t,) each; empty where the torque is the input.
    """

    names: tuple[str, ...]
    torque: Array
    inputs: Mapping[str, Array]


def read_drive(
    table: Table,
    joint: int,
    stated: StatedDrive,
    *,
    alone: bool,
    motion: tuple[Array, Array],
    slides: bool,
    gain: float,
) -> DriveColumns:
    """Read the columns of a driven joint.

    Parameters
    ----------
    table
        Table of the run.
    joint
        Number of the joint.
    stated
        Drive of the joint.
    alone
        Whether no other joint is free. Several free joints take torques: that of the stated parameters.
    motion
        Position [rad] ([m]) and speed, shape (n_t,) each.
    slides
        Whether the joint is prismatic.
    gain
        Gain of the controller in this run, in the drive's unit per rad.

    Returns
    -------
    DriveColumns

    Raises
    ------
    InputError
        Where a column is missing or a cell is impossible.
    """
    drive = stated.drive if alone else replace(stated.drive, controller=None)
    columns = _columns(drive.kind, joint, slides)
    if drive.is_closed:
        columns = {REFERENCE: f"reference_{joint}_{'m' if slides else 'rad'}"} | columns
        columns.pop(drive.kind)
    if SUPPLY in columns and columns[SUPPLY] not in table.columns:
        todo = advice(columns[SUPPLY], table.columns)
        todo = todo or "add it: the voltage of the motor's amplifier in every row, the same number where it is constant"
        raise InputError(table.header, expected="a column supply_V beside a duty", got="none", todo=todo)
    inputs = {id: table.numbers(name) for id, name in columns.items()}
    if SUPPLY in inputs:
        _check(table, columns[SUPPLY], inputs[SUPPLY], inputs[SUPPLY] > 0, "a positive supply voltage")
    if "duty" in inputs:
        within = np.abs(inputs["duty"]) <= LARGEST_DUTY
        _check(table, columns["duty"], inputs["duty"], within, "a duty from -1 to 1")
    names, inputs[ENABLED] = read_enabled(table, joint)
    inputs[GAIN] = np.full(motion[0].size, gain)
    ordered = {x.id: inputs[x.id] for x in drive_inputs(drive)}
    values = {q.id: stated.guess(q.id) if q.id in stated_ids(stated) else q.initial for q in drive_quantities(drive)}
    torque = torque_along(drive, values, ordered, *motion, table.time())
    most = THRESHOLDS.largest_reading
    _check(table, "time_s", torque, np.abs(torque) < most, f"a torque of the drive below {most:g} N m")
    return DriveColumns(names=(*columns.values(), *names), torque=torque, inputs=ordered if alone else {})


def stated_ids(stated: StatedDrive) -> tuple[str, ...]:
    """Return the ids of the drive's parameters that a campaign may state.

    Parameters
    ----------
    stated
        Drive of a joint; its controller is left out.

    Returns
    -------
    tuple of str
        Ids in the order of the drive's parameters.
    """
    return tuple(q.id for q in drive_quantities(replace(stated.drive, controller=None)))


def read_enabled(table: Table, joint: int) -> tuple[tuple[str, ...], Array]:
    """Read the switch of a motor: 1, or 0 while it is let go.

    Parameters
    ----------
    table
        Table of the run.
    joint
        Number of the joint.

    Returns
    -------
    names
        The column, where there is one.
    enabled : ndarray, shape (n_t,)
        1 without a column.

    Raises
    ------
    InputError
        Where a cell holds neither 0 nor 1.
    """
    name = f"enabled_{joint}"
    if name not in table.columns:
        return (), np.ones(table.time().size)
    values = table.numbers(name)
    _check(table, name, values, np.isin(values, (0.0, 1.0)), "0 or 1")
    return (name,), values


def _columns(kind: str, joint: int, slides: bool) -> dict[str, str]:
    torque = f"force_{joint}_N" if slides else f"torque_{joint}_Nm"
    columns = {kind: COMMANDS.get(kind, torque).format(joint=joint)}
    return columns | {SUPPLY: "supply_V"} if kind == "duty" else columns


def _check(table: Table, name: str, values: Array, good: NDArray[np.bool_], expected: str) -> None:
    if not bool(good.all()):
        row = int(np.flatnonzero(~good)[0])
        where = f"{table.row(row)}, column {name}"
        raise InputError(where, expected=expected, got=f"{values[row]:g}")
