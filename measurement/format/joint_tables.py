"""Read the ``[joint.J]`` tables: `TomlSource` in, parameters, friction law, sensor and drive by joint number out."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from haptid.measurement.format import schema
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.warning import warn
from haptid.model.device.stated_parameters import ROWS, check_parameters, with_positive_bound
from haptid.model.joint.parameter_table import all_ids, parameter_rows
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

Overrides = dict[int, dict[str, dict[str, Any]]]


def joint_tables(source: TomlSource) -> dict[int, dict[str, Any]]:
    """Return the ``[joint.J]`` tables by joint number.

    Parameters
    ----------
    source
        The parsed ``campaign.toml``.

    Returns
    -------
    dict
        Tables with known keys of the right kind; their parameters and sensors are checked elsewhere.

    Raises
    ------
    InputError
        Where a table is headed by no joint number, or holds an unknown key or a value of another kind.
    """
    tables = source.data.get("joint", {})
    if not isinstance(tables, dict):
        raise InputError(source.where("", "joint"), expected="tables [joint.J]", got=repr(tables))
    for name in tables:
        if not re.fullmatch(r"0|[1-9][0-9]{0,3}", name):
            got = repr(name)
            raise InputError(source.where(f"joint.{name}"), expected="a joint number, as in [joint.4]", got=got)
    return {int(name): schema.check_table(source, tables[name], schema.JOINT, f"joint.{name}") for name in tables}


def read_overrides(source: TomlSource, tables: dict[int, dict[str, Any]]) -> Overrides:
    """Return the ``[joint.J.parameters]`` by joint number.

    Parameters
    ----------
    source
        The parsed ``campaign.toml``, for the places that errors name.
    tables
        What `joint_tables` returned.

    Returns
    -------
    dict
        ``{joint: {parameter: {initial, lower, upper, fixed, prior}}}``, in SI units.

    Raises
    ------
    InputError
        Where the friction law of a joint has no such parameter, or its value, bounds or prior are impossible.
    """
    return {j: _parameters(source, table, j) for j, table in tables.items() if "parameters" in table}


def friction_laws(tables: dict[int, dict[str, Any]]) -> dict[int, str]:
    """Return the id of the friction law by joint, for the joints whose tables name one.

    Parameters
    ----------
    tables
        Joint → table of ``campaign.toml``.

    Returns
    -------
    dict
        Joint → id of its law; empty where no table names one.
    """
    return {joint: table["friction"] for joint, table in tables.items() if "friction" in table}


def _parameters(source: TomlSource, joint_table: dict[str, Any], joint: int) -> dict[str, dict[str, Any]]:
    section, table = f"joint.{joint}.parameters", joint_table["parameters"]
    # Without a law in the campaign, the device's holds, which is not read yet: parameters of any law pass here, and
    # `check_stated` refuses those that the joint lacks.
    named = "friction" in joint_table
    known = tuple(row.id for row in parameter_rows(joint_table["friction"])) if named else all_ids()
    for name, value in table.items():
        if name not in known:
            todo = did_you_mean(name, known)
            raise InputError(source.where(section, name), expected="a parameter of a joint", got=repr(name), todo=todo)
        if not isinstance(value, dict):
            todo = f"write {name} = {{ initial = {value} }} or {name} = {{ fixed = {value} }}"
            raise InputError(source.where(section, name), expected="a table", got=repr(value), todo=todo)
        schema.check_parameter(source, value, section, name)
    check_parameters(table, lambda name: source.where(section, name))
    for name, entry in table.items():
        if ROWS[name].fixed and {"lower", "upper"} & set(entry) and "prior" not in entry:
            where = source.where(section, name)
            warn(f"{where}: {name} stays fixed, as torque and position do not tell its scale: a prior would free it")
    return {name: with_positive_bound(name, value) for name, value in table.items()}


def warn_of_unused(source: TomlSource, tables: dict[int, dict[str, Any]], joints: set[int]) -> None:
    """Warn of each table of a joint outside ``joints``, the joints that some run frees: its number may be mistyped.

    Parameters
    ----------
    source
        Text of ``campaign.toml``, which names the place.
    tables
        Joint → table of ``campaign.toml``.
    joints
        Numbers of the joints that some run frees.
    """
    for joint in sorted(set(tables) - joints):
        there = ", ".join(map(str, sorted(joints)))
        where = source.where(f"joint.{joint}")
        warn(f"{where}: no run frees joint {joint} (joints with runs: {there}): nothing uses it")


def sensor_of(
    source: TomlSource, tables: dict[int, dict[str, Any]], joints: tuple[int, ...], prismatic: tuple[bool, ...]
) -> tuple[Array, Array]:
    """Return the stated noise and encoder step of the free joints of a run.

    Parameters
    ----------
    source
        The parsed ``campaign.toml`` with its table ``[sensor]``.
    tables
        What `joint_tables` returned; ``[joint.J.sensor]`` overrules ``[sensor]`` key by key.
    joints, prismatic
        Free joints, ascending, and whether each is prismatic.

    Returns
    -------
    noise, resolution : ndarray, shape (n_joints,)
        Standard deviation of the white noise and encoder step [rad] ([m]); NaN where neither table states it.
    """
    common = source.data.get("sensor", {})
    own = [{**common, **tables.get(joint, {}).get("sensor", {})} for joint in joints]
    units = ["m" if slides else "rad" for slides in prismatic]
    noise = [table.get(f"noise_{unit}", np.nan) for table, unit in zip(own, units, strict=True)]
    step = [table.get(f"resolution_{unit}", np.nan) for table, unit in zip(own, units, strict=True)]
    return np.array(noise, dtype=np.float64), np.array(step, dtype=np.float64)


def refuse_unread_sensor(source: TomlSource, tables: dict[int, dict[str, Any]], runs: Sequence[Run]) -> None:
    """Refuse a statement on the sensor in rad where all joints that it is about slide, or in m where all turn.

    Parameters
    ----------
    source
        The parsed ``campaign.toml`` with its table ``[sensor]``.
    tables
        What `joint_tables` returned.
    runs
        All runs of the campaign.

    Raises
    ------
    InputError
        For a key that nothing reads, unless the same is stated in the other unit as well.
    """
    motions = {pair for run in runs for pair in zip(run.free_joints, run.prismatic, strict=True)}
    places = [("sensor", source.data.get("sensor", {}), {slides for _, slides in motions})]
    for joint in sorted(tables):
        kinds = {slides for moved, slides in motions if moved == joint}
        places.append((f"joint.{joint}.sensor", tables[joint].get("sensor", {}), kinds))
    for section, table, kinds in places:
        if len(kinds) != 1:
            continue
        (slides,) = kinds
        unread, unit = ("rad", "m") if slides else ("m", "rad")
        for quantity in ("noise", "resolution"):
            key, right = f"{quantity}_{unread}", f"{quantity}_{unit}"
            if key in table and right not in table:
                expected = f"{right} of joints that {'slide' if slides else 'turn'}"
                where = source.where(section, key)
                raise InputError(where, expected=expected, got=key, todo=f"state it in {unit}, as {right}")


def drive_constants(tables: dict[int, dict[str, Any]]) -> dict[int, float]:
    """Return torque (force) per ampere [N m/A] ([N/A]) by joint, for the joints whose tables state it.

    Parameters
    ----------
    tables
        Joint → table of ``campaign.toml``.

    Returns
    -------
    dict
        Joint → constant.
    """
    keys = ("torque_constant_Nm_per_A", "force_constant_N_per_A")
    return {joint: float(table[key]) for joint, table in tables.items() for key in keys if key in table}
