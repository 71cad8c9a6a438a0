"""Read a campaign: folder in, `Campaign` out, checked to the last cell (INTERFACES, section 2).

1. Parse ``campaign.toml`` and check the names of its tables.
2. Resolve the device, whose joint count the next steps need.
3. Check the ``[joint.J]`` tables and read the table of each ``[[runs]]`` entry.
4. Warn of unknown columns and of tables of joints that no run frees.
5. Give runs whose locked joints stand within what readings tell one posture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.format import schema
from haptid.measurement.format.devices import joint_count, joint_range, resolve_device
from haptid.measurement.format.drives import StatedDrive, read_drives
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.joint_tables import (
    Overrides,
    drive_constants,
    friction_laws,
    joint_tables,
    read_overrides,
    refuse_unread_sensor,
    warn_of_unused,
)
from haptid.measurement.format.run_entries import Reading, read_runs, table_inside
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.postures import join_postures
from haptid.measurement.values.warning import warn
from haptid.model.device.device import Device
from haptid.support.command import word_command
from haptid.support.errors import InputError, one_line
from haptid.support.suggestion import did_you_mean

TABLES = ("campaign", "sensor", "joint", "runs")
RESULTS = ("identification.json", "posterior.json")
"""Files by which a folder is known for one with results, which is easily named for that of a campaign."""


def read_campaign(folder: Path | str | None = None) -> Campaign:
    """Read and check a campaign.

    Parameters
    ----------
    folder
        The folder with ``campaign.toml``; None for the embedded Freedom 6S campaign, the planned one.

    Returns
    -------
    Campaign
        Noise and resolution are NaN where the campaign does not state them; no run is held out yet.

    Raises
    ------
    InputError
        With file, line or key, what was expected and what came, at the first fault.

    Warns
    -----
    CampaignWarning
        Once for unknown extra columns; once for each table of a joint that no run frees;
        once for a device file that is missing and has a built-in namesake.
    """
    folder = embedded_campaign() if folder is None else Path(folder)
    if is_foreign(folder):
        where, takers = str(folder / "campaign.toml"), (("identify", "identification.run"), ("posterior", "uq.run"))
        todo = f"{' and '.join(word_command(*taker) for taker in takers)} take it"
        raise InputError(where, expected="a campaign about joints", got="one about an FMU", todo=todo)
    return campaign_from(open_source(folder, TABLES), folder, table_inside(folder))


def campaign_from(source: TomlSource, folder: Path, read: Reading, loaded: Device | None = None) -> Campaign:
    """Make a campaign of its description and its tables, wherever both come from.

    Parameters
    ----------
    source
        Content of ``campaign.toml``.
    folder
        Folder from which the paths of devices start.
    read
        Function from the name of a table and the place of the name to the table.
    loaded
        Device that the description names, where a program hands it over; None to load it by its name.

    Returns
    -------
    Campaign
        See `read_campaign`, also for errors and warnings.
    """
    schema.check_table(source, source.data.get("sensor", {}), schema.SENSOR, "sensor")
    head = schema.check_table(source, source.data.get("campaign"), schema.CAMPAIGN, "campaign")
    if loaded is None:
        device = resolve_device(head["device"], folder, source.where("campaign", "device"))
        count = joint_count(device)
    else:
        device, count = head["device"], len(loaded.joints)
    tables = _joint_tables(source, device, count)
    drives = read_drives(source, tables)
    runs, unknown = read_runs(source, device, count, head.get("hold", "zero"), tables, drives, read)
    if unknown:
        warn(f"{folder}: columns that the format does not know are kept and not used: {', '.join(unknown)}")
    refuse_unread_sensor(source, tables, runs)
    warn_of_unused(source, tables, {joint for run in runs for joint in run.free_joints})
    named = {"title", "device", "measured", "hold"}
    return Campaign(
        folder=folder,
        title=one_line(head.get("title", folder.resolve().name)),
        device=device,
        measured=head["measured"],
        hold=head.get("hold", "zero"),
        runs=join_postures(runs),
        parameter_overrides=_with_drives(read_overrides(source, tables), drives),
        drives={joint: stated.drive for joint, stated in drives.items()},
        torque_constants=drive_constants(tables),
        friction=friction_laws(tables),
        noise_given=all(bool(np.isfinite(run.noise).all()) for run in runs),
        loaded=loaded,
        extra={
            **{name: value for name, value in source.data.items() if name not in TABLES},
            **{name: value for name, value in head.items() if name not in named},
        },
    )


def _with_drives(overrides: Overrides, drives: Mapping[int, StatedDrive]) -> Overrides:
    """Return the stated parameters with those of the drives."""
    known = {joint: dict(stated.parameters) for joint, stated in drives.items() if stated.parameters}
    return {joint: {**overrides.get(joint, {}), **known.get(joint, {})} for joint in sorted({*overrides, *known})}


def open_source(folder: Path, tables: Sequence[str]) -> TomlSource:
    """Parse the ``campaign.toml`` of a folder, and refuse tables whose names are mistyped.

    Parameters
    ----------
    folder
        Folder of the campaign.
    tables
        Names of the tables that are read.

    Returns
    -------
    TomlSource
        Content of the file, with the places of its keys.

    Raises
    ------
    InputError
        Where there is no such file, it is no TOML, or one of its tables is mistyped.
    """
    if not folder.is_dir():
        got = "a file" if folder.exists() else "no such folder"
        raise InputError(str(folder), expected="the folder of a campaign", got=got)
    path = folder / "campaign.toml"
    if not path.is_file():
        todo = f"make it with {word_command('init', 'measurement.new')} {folder} --out NEW_FOLDER"
        if any((folder / name).is_file() for name in RESULTS):
            todo = "this folder holds results: name that of the campaign they were made of"
        raise InputError(str(path), expected="the file that describes the campaign", got="no such file", todo=todo)
    source = TomlSource.parse(path)
    for name in source.data:
        todo = did_you_mean(name, tables)
        mistyped = todo.startswith("did") or not isinstance(source.data[name], dict)
        if name not in (*tables, "source") and mistyped:
            raise InputError(source.where("", name), expected="a known table", got=repr(name), todo=todo)
    return source


def is_foreign(folder: Path | str | None) -> bool:
    """Whether a folder's ``campaign.toml`` is about an FMU and not about joints: its head names a model and no device.

    Parameters
    ----------
    folder
        Folder of a campaign; None for the embedded one.

    Returns
    -------
    bool
        False where the file cannot be read: the reader of joints says why.

    Raises
    ------
    InputError
        Where campaign.toml cannot be read, or is no TOML.
    """
    if folder is None or not (Path(folder) / "campaign.toml").is_file():
        return False
    data = TomlSource.parse(Path(folder) / "campaign.toml").data
    head = data.get("campaign")
    return isinstance(head, dict) and "device" not in head and ("model" in head or "outputs" in data)


def _joint_tables(source: TomlSource, device: str, count: int | None) -> dict[int, dict[str, Any]]:
    tables = joint_tables(source)
    for joint, table in tables.items():
        schema.check_table(source, table.get("sensor", {}), schema.OWN_SENSOR, f"joint.{joint}.sensor")
        if count is not None and joint >= count:
            expected = f"a joint of {device}, {joint_range(count)}"
            raise InputError(source.where(f"joint.{joint}"), expected=expected, got=str(joint))
    return tables
