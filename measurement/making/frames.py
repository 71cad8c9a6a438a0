"""A campaign from tables in memory: data frames and `Answers` in, `Campaign` out, checked as one that is read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from haptid.measurement.format.devices import SUFFIXES
from haptid.measurement.format.reading import campaign_from
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.making.answers import Answers
from haptid.measurement.making.prepared import describe_campaign, prepare_tables
from haptid.measurement.making.times import assume_time, has_time, is_time, with_seconds
from haptid.measurement.naming.mapping import Target
from haptid.measurement.tables.table import Table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warn
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.support.errors import InputError

MOST_SHOWN_RUNS = 4
"""Runs that a remark names."""
FOLDER = Path("frames")
"""Stands in errors for the folder that such a campaign does not have: ``frames/run1, row 7``."""


def campaign_from_frames(
    frames: Mapping[str, pd.DataFrame], answers: Answers, joints: Mapping[int, Mapping[str, Any]]
) -> Campaign:
    """Make a campaign of data frames.

    Parameters
    ----------
    frames
        Table of each run by its name, with the columns of a run's file; units in names are converted to SI.
    answers
        What the user states of them.
    joints
        Tables ``[joint.J]`` of ``campaign.toml`` by number of the joint.

    Returns
    -------
    Campaign
        As `read_campaign` returns one, not yet ready for fits; its remarks say what was done to the tables.

    Raises
    ------
    InputError
        With name, row and column of the first fault.

    Warns
    -----
    CampaignWarning
        As `read_campaign`; also where a position is counted on and a run is cut.
    """
    device, loaded = _device_of(answers)
    known = replace(
        answers,
        device=answers.device if loaded is None else loaded,
        closed=frozenset(int(joint) for joint, table in joints.items() if "controller" in table),
    )
    tables = []
    told: dict[str, list[str]] = {}
    """Names of the runs by what was done to them."""
    for name, frame in frames.items():
        table, assumed = assume_time(with_seconds(table_of(name, frame), answers.stated)[0], answers.stated)
        _refuse_time_in_index(table, frame, answers.stated)
        tables.append(table)
        if assumed is not None:
            taken = (
                f"column {assumed.column!r} is taken for {assumed.words}, as it has no unit; columns= states another"
            )
            told.setdefault(taken, []).append(name)
    prepared = prepare_tables(tables, known, mend=False)
    content = describe_campaign(prepared, answers, device)
    if joints:
        content["joint"] = _with_statements(content.get("joint", {}), joints)
    by_file = {one.file: table_of(one.file, one.frame) for one in prepared}
    campaign = campaign_from(
        TomlSource(path=FOLDER, text="", data=content), FOLDER, lambda name, _where: by_file[name], loaded
    )
    for one in prepared:
        for sentence in one.about:
            told.setdefault(sentence, []).append(one.file)
    remarks = tuple(f"{_list_runs(names)}: {sentence}" for sentence, names in told.items())
    for remark in remarks:
        warn(remark)
    return campaign.but(remarks=remarks)


def _list_runs(names: Sequence[str]) -> str:
    """Name the runs that one sentence is about; of many the first ones."""
    shown = (
        names
        if len(names) <= MOST_SHOWN_RUNS
        else [*names[: MOST_SHOWN_RUNS - 1], f"{len(names) - MOST_SHOWN_RUNS + 1} more"]
    )
    return " and ".join([", ".join(shown[:-1]), shown[-1]]) if len(shown) > 1 else shown[0]


def frames_by_name(frames: object) -> dict[str, pd.DataFrame]:
    """Return the tables of runs by name, from a mapping or a list of them.

    Parameters
    ----------
    frames
        What the caller gave.

    Returns
    -------
    dict
        ``run0``, ``run1`` … are the names of a list.

    Raises
    ------
    InputError
        Where it is neither, as a bare data frame, or holds no table.
    """
    expected, todo = "data frames by the name of their run, or a list of them", 'write {"run": df}'
    # A data frame is iterable: its columns' names would be taken for tables.
    if isinstance(frames, pd.DataFrame | str) or not isinstance(frames, Iterable):
        raise InputError(str(FOLDER), expected=expected, got=f"one {type(frames).__name__}", todo=todo)
    tables = dict(frames) if isinstance(frames, Mapping) else {f"run{k}": one for k, one in enumerate(frames)}
    if not tables:
        raise InputError(str(FOLDER), expected=expected, got="none", todo=todo)
    return tables


def _refuse_time_in_index(table: Table, frame: pd.DataFrame, stated: Mapping[str, Target]) -> None:
    """Refuse a table without a time whose index is likely that time."""
    index = frame.index
    if has_time(table, stated) or isinstance(index, pd.MultiIndex):
        return
    dated = isinstance(index, pd.DatetimeIndex | pd.TimedeltaIndex)
    named = index.name is not None and is_time(str(index.name))
    numbered = index.name is None and pd.api.types.is_float_dtype(index.dtype) and index.is_monotonic_increasing
    if dated or named or numbered:
        how = "df.reset_index()" if index.name is not None else 'df.reset_index(names="time_s")'
        todo = f"make the index a column, as by {how}"
        raise InputError(str(table.path), expected="a column time_s", got="none, and a time as the index", todo=todo)


def _with_statements(found: Mapping[str, Any], joints: Mapping[int, Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Return the tables of joints: a statement on friction does not take back the drive that the columns tell."""
    tables = dict(found)
    for joint, stated in joints.items():
        known = found.get(str(joint), {})
        drive = stated.get("drive", {})
        if isinstance(drive, Mapping):  # else the check of the campaign says what it is
            drive = known.get("drive", {}) | dict(drive)
        tables[str(joint)] = {**known, **stated, **({"drive": drive} if drive else {})}
    return tables


def table_of(name: str, frame: pd.DataFrame) -> Table:
    """Return the table that a data frame is.

    Parameters
    ----------
    name
        Name of the run.
    frame
        Its columns; the index counts for nothing.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        Where the name is a path, it is no data frame, two columns have one name, or it has fewer than 8 rows.
    """
    if not isinstance(name, str):
        raise InputError(str(FOLDER), expected="texts as names of runs", got=repr(name), todo=f'write "{name}"')
    path = FOLDER / name
    if path.name != name:
        raise InputError(str(FOLDER), expected="names of runs without slashes", got=repr(name))
    if not isinstance(frame, pd.DataFrame):
        raise InputError(str(path), expected="a pandas DataFrame", got=type(frame).__name__)
    columns = pd.Index([str(column).strip() for column in frame.columns])
    if columns.has_duplicates:
        doubled = columns[columns.duplicated()][0]
        raise InputError(str(path), expected=f"one column {doubled}", got="several")
    if len(frame) < THRESHOLDS.least_rows_of_table:
        raise InputError(str(path), expected=f"at least {THRESHOLDS.least_rows_of_table} rows", got=f"{len(frame)}")
    return Table(path=path, frame=frame.set_axis(columns, axis=1).reset_index(drop=True), in_memory=True)


def _device_of(answers: Answers) -> tuple[str, Device | None]:
    """Return how the campaign names its device, and the device where a file or the program says what it is."""
    if isinstance(answers.device, Device):
        # Not the bare name: a stored result would be exported with the built-in device of that name.
        return f"{answers.device.name} (given as a Device)", answers.device
    return answers.device, load_device(answers.device) if answers.device.endswith(SUFFIXES) else None
