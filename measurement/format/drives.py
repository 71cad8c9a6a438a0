"""Read ``[joint.J.drive]`` and ``[joint.J.controller]``: checked tables in, `StatedDrive` by joint number out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from haptid.measurement.format import schema
from haptid.measurement.format.toml_source import TomlSource
from haptid.model.device.stated_parameters import ROWS, check_parameters, stated_value, with_positive_bound
from haptid.model.equations.drive import Controller, Drive
from haptid.support.errors import InputError

PARAMETERS: Mapping[str, tuple[str, ...]] = {"torque": (), "current": ("torque_constant",)}
"""Parameters that a kind of drive has; every other kind has both."""
TERMS = {"derivative_gain": ("pd", "pid"), "integral_gain": ("pid",)}
"""Kinds of controller that have a gain beside the proportional one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedDrive:
    """Drive of a joint as ``campaign.toml`` states it.

    Parameters
    ----------
    drive
        Kind and controller.
    parameters
        ``{torque_constant | resistance_ohm: {initial, lower, upper, fixed, prior}}``, in SI units.
    """

    drive: Drive
    parameters: Mapping[str, dict[str, Any]]

    def guess(self, id: str) -> float:
        """Return the stated value of a parameter, else the geometric mean of its bounds, else a default within them.

        Parameters
        ----------
        id
            Id of a parameter of the drive.

        Returns
        -------
        float
            Value in the parameter's SI unit; the default is clipped where one bound is stated.
        """
        entry, row = self.parameters.get(id, {}), ROWS[id]
        value = stated_value(entry)
        if value is not None:
            return value
        if {"lower", "upper"} <= set(entry):
            return math.sqrt(entry["lower"] * entry["upper"])
        return min(max(row.initial, entry.get("lower", row.lower)), entry.get("upper", row.upper))


def read_drives(source: TomlSource, tables: Mapping[int, Mapping[str, Any]]) -> dict[int, StatedDrive]:
    """Return the drives by joint.

    Parameters
    ----------
    source
        The parsed ``campaign.toml``.
    tables
        The checked ``[joint.J]`` tables by joint number.

    Returns
    -------
    dict
        Of the joints whose recorded quantity is not the torque, or whose controller is stated.

    Raises
    ------
    InputError
        Where a key is unknown or missing, a value is of another kind, or two statements contradict each other.
    """
    drives = {}
    for joint, table in tables.items():
        stated = _drive(source, table, joint)
        if stated.drive != Drive(kind="torque"):
            drives[joint] = stated
    return drives


def _drive(source: TomlSource, table: Mapping[str, Any], joint: int) -> StatedDrive:
    section = f"joint.{joint}.drive"
    entry = schema.check_table(source, table.get("drive", {"kind": "torque"}), schema.DRIVE, section)
    known = PARAMETERS.get(entry["kind"], ("torque_constant", "resistance_ohm"))
    parameters: dict[str, dict[str, Any]] = {}
    for id, value in entry.items():
        if id == "kind":
            continue
        if id not in known:
            expected = f"a drive of kind current, voltage or duty for {id}" if not known else "a voltage or a duty"
            raise InputError(source.where(section, id), expected=expected, got=f"kind {entry['kind']!r}")
        parameters[id] = {"fixed": value} if schema.is_number(value) else dict(value)
        schema.check_parameter(source, parameters[id], section, id)
    check_parameters(parameters, lambda id: source.where(section, id))
    _check_gain(source, table, joint, parameters)
    return StatedDrive(
        drive=Drive(kind=entry["kind"], controller=_controller(source, table, joint)),
        parameters={id: _guess_between_bounds(id, value) for id, value in parameters.items()},
    )


def _guess_between_bounds(id: str, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry of bounds alone with the middle between them as its first guess."""
    full = with_positive_bound(id, entry)
    if stated_value(full) is None and {"lower", "upper"} <= set(full):
        full["initial"] = math.sqrt(full["lower"] * full["upper"])
    return full


def _check_gain(
    source: TomlSource, table: Mapping[str, Any], joint: int, parameters: Mapping[str, Mapping[str, Any]]
) -> None:
    """Refuse a second statement of the torque constant, and a plant gain that is free beside it."""
    section = f"joint.{joint}.drive"
    for key in ("torque_constant_Nm_per_A", "force_constant_N_per_A"):
        if key in table and "drive" in table:
            todo = f"keep torque_constant under [{section}]"
            raise InputError(source.where(f"joint.{joint}", key), expected="one torque constant", got="two", todo=todo)
    gain = table.get("parameters", {}).get("Kp", {})
    has_constant = table.get("drive", {}).get("kind", "torque") != "torque"
    is_free = "fixed" not in parameters.get("torque_constant", {})
    if has_constant and is_free and isinstance(gain, dict) and "prior" in gain:
        todo = "fix Kp or torque_constant: the data tell only their product"
        where = source.where(f"joint.{joint}.parameters", "Kp")
        raise InputError(where, expected="one free gain", got="Kp and torque_constant", todo=todo)


def _controller(source: TomlSource, table: Mapping[str, Any], joint: int) -> Controller | None:
    if "controller" not in table:
        return None
    section = f"joint.{joint}.controller"
    entry = schema.check_table(source, table["controller"], schema.CONTROLLER, section)
    for key, kinds in TERMS.items():
        if (key in entry) != (entry["kind"] in kinds):
            expected = f"{key} for a controller of kind {' or '.join(kinds)} alone"
            got = f"kind {entry['kind']!r} {'with' if key in entry else 'without'} it"
            raise InputError(source.where(section, key if key in entry else "kind"), expected=expected, got=got)
    gains = {key: float(value) for key, value in entry.items() if key != "kind"}
    return Controller(kind=entry["kind"], **gains)
