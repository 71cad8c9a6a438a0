"""Read the ``[[runs]]`` of a campaign: `TomlSource` in, one `Run` per entry out, each entry and its table checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.format import schema
from haptid.measurement.format.columns import Signals, read_signals
from haptid.measurement.format.devices import SINGLE_JOINT, joint_range
from haptid.measurement.format.drives import StatedDrive
from haptid.measurement.format.joint_tables import drive_constants, sensor_of
from haptid.measurement.format.places import check_inside
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.tables.table import Table, read_table
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError, one_line

Reading = Callable[[str, str], Table]
"""Function from the name of a table, and the place of that name for errors, to the table."""


def table_inside(folder: Path) -> Reading:
    """Return the function that reads a table below the folder of a campaign.

    Parameters
    ----------
    folder
        Folder with ``campaign.toml``.

    Returns
    -------
    Reading
        It refuses a table outside ``folder`` as `check_inside` does.
    """

    def read(name: str, where: str) -> Table:
        check_inside(folder, name, where)
        return read_table(folder / name)

    return read


def read_runs(  # what the entries are read against, each once
    source: TomlSource,
    device: str,
    count: int | None,
    hold: str,
    tables: dict[int, dict[str, Any]],
    drives: Mapping[int, StatedDrive],
    read: Reading,
) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Read every table that ``[[runs]]`` lists.

    Parameters
    ----------
    source
        The parsed ``campaign.toml``.
    device
        A built-in name, ``single_joint`` or the path of a device file.
    count
        Number of its joints; None where it is not known.
    hold
        ``zero`` or ``linear``, for the entries that state nothing.
    tables
        The checked ``[joint.J]`` tables by joint number.
    drives
        Drives by joint number.
    read
        Function that reads the table of an entry.

    Returns
    -------
    runs
        In the order of the file; noise and resolution are NaN where they are not stated.
    unknown
        Names of columns that the format does not know, each once.

    Raises
    ------
    InputError
        Where an entry or a table is at fault, no run is to be fitted, or a joint has a validation run but no fit run.
    """
    listed = source.data.get("runs")
    if not isinstance(listed, list) or not listed:
        raise InputError(source.where("runs"), expected="at least one [[runs]]", got=repr(listed))
    runs: list[Run] = []
    unknown: dict[str, None] = {}
    seen: set[str] = set()
    for index, entry in enumerate(listed):
        schema.check_table(source, entry, schema.RUN, "runs", index)
        _check_entry(source, entry, index, device, count, seen)
        seen.add(entry["file"])
        table = read(entry["file"], f"{source.path}, runs[{index}].file")
        joints = tuple(sorted(entry["free_joints"]))
        _check_gain(source, entry, index, joints, drives)
        signals = read_signals(table, joints, drive_constants(tables), drives, entry.get("controller_gain"))
        noise, resolution = sensor_of(source, tables, joints, signals.prismatic)
        unknown.update(dict.fromkeys(signals.unknown))
        run = _make_run({"hold": hold, **entry}, signals, _posture(entry, device, count))
        averaged = source.data.get("sensor", {}).get("averaged_rows", 0)
        runs.append(run.but(noise=noise, resolution=resolution, averaged_rows=averaged))
    _check_fit_runs(source, runs)
    return tuple(runs), tuple(unknown)


def _make_run(entry: dict[str, Any], signals: Signals, posture: Array) -> Run:
    joints = tuple(sorted(entry["free_joints"]))
    return Run(
        file=entry["file"],
        free_joints=joints,
        t=signals.t - signals.t[0],
        start_time=float(signals.t[0]),
        u=signals.u,
        y=signals.y,
        v=signals.v,
        prismatic=signals.prismatic,
        extra=signals.extra,
        drive_inputs=signals.drive_inputs,
        posture=posture,
        noise=np.full(len(joints), np.nan),
        resolution=np.full(len(joints), np.nan),
        use=entry["use"],
        hold=entry["hold"],
        reason=one_line(entry.get("reason", "")),
        notes=(one_line(str(entry["note"])),) if "note" in entry else (),
    )


def _posture(entry: dict[str, Any], device: str, count: int | None) -> Array:
    given = entry.get("locked_positions_rad")
    if device == SINGLE_JOINT:
        return np.zeros(0)
    return np.array(given, dtype=np.float64) if given is not None else np.zeros(count or 0)


def _check_entry(
    source: TomlSource, entry: dict[str, Any], index: int, device: str, count: int | None, seen: set[str]
) -> None:
    if entry["file"] in seen:
        where = source.where("runs", "file", index)
        raise InputError(where, expected="each table once", got=f"{entry['file']!r} again")
    if entry["use"] == "excluded" and not entry.get("reason"):
        where = source.where("runs", "reason", index)
        raise InputError(where, expected="a reason why the run is excluded", got="none", todo='add reason = "…"')
    if device == SINGLE_JOINT and len(entry["free_joints"]) > 1:
        todo = "list each joint's runs apart, or name a device with several joints"
        where = source.where("runs", "free_joints", index)
        raise InputError(where, expected="one free joint for single_joint", got=str(entry["free_joints"]), todo=todo)
    if count is not None and max(entry["free_joints"]) >= count:
        where = source.where("runs", "free_joints", index)
        raise InputError(where, expected=f"joints of {device}, {joint_range(count)}", got=str(entry["free_joints"]))
    posture = entry.get("locked_positions_rad")
    if count is not None and posture is not None and len(posture) != count:
        where = source.where("runs", "locked_positions_rad", index)
        raise InputError(where, expected=f"{count} numbers, one per joint of {device}", got=f"{len(posture)}")


def _check_gain(
    source: TomlSource, entry: dict[str, Any], index: int, joints: tuple[int, ...], drives: Mapping[int, StatedDrive]
) -> None:
    closed = len(joints) == 1 and joints[0] in drives and drives[joints[0]].drive.is_closed
    if "controller_gain" in entry and not closed:
        where, expected = source.where("runs", "controller_gain", index), f"a table [joint.{joints[0]}.controller]"
        raise InputError(where, expected=expected, got="none" if len(joints) == 1 else f"free joints {list(joints)}")


def _check_fit_runs(source: TomlSource, runs: list[Run]) -> None:
    fitted = {run.free_joints for run in runs if run.use == "fit"}
    if not fitted:
        raise InputError(source.where("runs"), expected='at least one run with use = "fit"', got="none")
    for index, run in enumerate(runs):
        if run.use == "validate" and len(run.free_joints) == 1 and run.free_joints not in fitted:
            where = source.where("runs", "use", index)
            expected = f'a run with use = "fit" for joint {run.free_joints[0]}'
            raise InputError(where, expected=expected, got='only use = "validate"')
