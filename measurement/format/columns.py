"""Pick the columns of the free joints: `Table` in, `Signals` out, the arrays of a run."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from haptid.measurement.format.drive_columns import DriveColumns, read_drive, read_enabled
from haptid.measurement.format.drives import StatedDrive
from haptid.measurement.tables.table import Table
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

JOINT = r"\d{1,3}"
"""Pattern of a joint's number in a name: no device has a thousand joints, and longer digits are no number."""
NUMBERED = re.compile(rf"_({JOINT})(?=_|$)")
"""The joint's number in a name of the campaign format."""
KNOWN = re.compile(
    rf"time_s|(torque|torque_command|torque_measured)_{JOINT}_Nm|(force|force_command|force_measured)_{JOINT}_N"
    rf"|current_{JOINT}_A|voltage_{JOINT}_V|duty_{JOINT}|supply_V|enabled_{JOINT}|temperature_{JOINT}_C"
    rf"|(position|reference)_{JOINT}_(rad|m)|(velocity|reference_velocity)_{JOINT}_(rad_s|m_s)"
)
"""Names of all columns that the campaign format has; others are kept with a warning."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Signals:
    """Hold the arrays of one run as its table states them.

    Parameters
    ----------
    t
        Time as the table has it [s], shape (n_t,), strictly increasing; it need not start at 0.
    u
        Torques [N m] (forces [N]), shape (n_t, n_joints).
    y
        Positions [rad] ([m]), shape (n_t, n_joints).
    v
        Velocities [rad/s] ([m/s]), shape (n_t, n_joints), or None where the table lacks one of them.
    prismatic
        Whether each joint is prismatic, shape (n_joints,).
    extra
        All other columns by name, each of shape (n_t,), NaN where a cell holds no number.
    drive_inputs
        Inputs of a single driven joint by id, as `Run` holds them; empty where torques are the inputs.
    """

    t: Array
    u: Array
    y: Array
    v: Array | None
    prismatic: tuple[bool, ...]
    extra: Mapping[str, Array]
    drive_inputs: Mapping[str, Array]

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the columns that the format does not know."""
        return tuple(name for name in self.extra if not KNOWN.fullmatch(name))


def read_signals(
    table: Table,
    joints: tuple[int, ...],
    constants: Mapping[int, float],
    drives: Mapping[int, StatedDrive] | None = None,
    gain: float | None = None,
) -> Signals:
    """Pick the columns of the free joints.

    Parameters
    ----------
    table
        Table of the run.
    joints
        Free joints, ascending. A joint with a column ``position_<j>_m`` is prismatic.
    constants
        Torque per ampere (force per ampere) of the joints whose drive is recorded in amperes [N m/A] ([N/A]);
        u = constant · current where the table has no torque.
    drives
        Drives by joint; those of joints that are not free count for nothing.
    gain
        Gain of the controller in this run; that of the drive where None.

    Returns
    -------
    Signals
        Velocities only where the table holds those of all free joints.

    Raises
    ------
    InputError
        Where a column is missing, a joint has positions in rad and in m, a current has no constant, or a cell that
        is needed holds no finite number.
    """
    t = table.time()
    prismatic = tuple(_is_prismatic(table, joint) for joint in joints)
    stated = drives or {}
    # Torques are read first: where a joint is mistyped, the error names the torque.
    columns = {
        joint: _input(table, joint, slides, constants)
        for joint, slides in zip(joints, prismatic, strict=True)
        if joint not in stated
    }
    units = ["m" if slides else "rad" for slides in prismatic]
    positions = [f"position_{joint}_{unit}" for joint, unit in zip(joints, units, strict=True)]
    velocities = [f"velocity_{joint}_{unit}_s" for joint, unit in zip(joints, units, strict=True)]
    measured = all(name in table.columns for name in velocities)
    y = np.stack([table.numbers(name) for name in positions], axis=1)
    v = np.stack([table.numbers(name) for name in velocities], axis=1) if measured else None
    for k, joint in enumerate(joints):
        if joint not in stated:
            continue
        controller = stated[joint].drive.controller
        own = controller.gain if controller else 0.0
        own = own if gain is None else gain
        motion, alone = (y[:, k], _speed(t, y[:, k]) if v is None else v[:, k]), len(joints) == 1
        columns[joint] = read_drive(
            table, joint, stated[joint], alone=alone, motion=motion, slides=prismatic[k], gain=own
        )
    inputs = [columns[joint] for joint in joints]
    used = {"time_s", *positions, *(velocities if measured else ()), *(name for one in inputs for name in one.names)}
    return Signals(
        t=t,
        u=np.stack([one.torque for one in inputs], axis=1),
        y=y,
        v=v,
        prismatic=prismatic,
        extra={name: table.loosely(name) for name in table.columns if name not in used},
        drive_inputs={id: column for one in inputs for id, column in one.inputs.items()},
    )


def _speed(t: Array, y: Array) -> Array:
    """Return the differenced position; 0 where the clock stands, which a later check refuses."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nan_to_num(np.gradient(y, t), posinf=0.0, neginf=0.0)


def _is_prismatic(table: Table, joint: int) -> bool:
    turns, slides = f"position_{joint}_rad" in table.columns, f"position_{joint}_m" in table.columns
    if turns and slides:
        got = f"position_{joint}_rad and position_{joint}_m"
        raise InputError(table.header, expected=f"one position of joint {joint}", got=got)
    return slides


def _input(table: Table, joint: int, slides: bool, constants: Mapping[int, float]) -> DriveColumns:
    name = f"force_{joint}_N" if slides else f"torque_{joint}_Nm"
    other = f"torque_{joint}_Nm" if slides else f"force_{joint}_N"
    current = f"current_{joint}_A"
    if name not in table.columns and other in table.columns:
        got = f"{other} beside position_{joint}_{'m' if slides else 'rad'}"
        ways = "slides has a force in N" if slides else "turns has a torque in N m"
        todo = f"a joint that {ways}: name that column {name}, with the factor to its unit"
        raise InputError(table.header, expected=f"a column {name}", got=got, todo=todo)
    if name in table.columns or current not in table.columns:
        return _switch_by_enabled(table, joint, name, table.numbers(name))
    if joint not in constants:
        key = "force_constant_N_per_A" if slides else "torque_constant_Nm_per_A"
        # Frames have no campaign.toml: what is known of their joints is an argument.
        inline, file = (
            f'give joints={{{joint}: {{"{key}": ...}}}}',
            f"give {key} under [joint.{joint}] in campaign.toml",
        )
        todo = inline if table.in_memory else file
        raise InputError(table.header, expected=f"a column {name}", got=current, todo=todo)
    return _switch_by_enabled(table, joint, current, constants[joint] * table.numbers(current))


def _switch_by_enabled(table: Table, joint: int, name: str, torque: Array) -> DriveColumns:
    names, enabled = read_enabled(table, joint)
    return DriveColumns(names=(name, *names), torque=torque * enabled, inputs={})
