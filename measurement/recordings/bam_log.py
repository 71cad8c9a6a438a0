"""Read a log of BAM (Rhoban, *Better Actuator Models*): JSON with a servo's entries in, one run out.

Such a log holds positions, speeds and goals in rad, times in s and the measured supply. It has no torque: the servo's
firmware makes it. Of an XL330, ``load`` is the duty of its amplifier in 885ths, so that the run has a drive; of other
servos it is left as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.measurement.recordings.one_run import Recording, recording_of
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError
from haptid.support.files.files import read_content, read_json

WANTED = "a log of BAM"
MOST_SHOWN_KEYS = 6
"""Keys of another file that an error shows."""
NAMES: Mapping[str, str] = {
    "timestamp": "time_s",
    "position": "position_0_rad",
    "speed": "velocity_0_rad_s",
    "goal_position": "reference_0_rad",
    "input_volts": "supply_V",
    "temp": "temperature_0_C",
    "torque_enable": "enabled_0",
    "load": "load",
}
"""Column of the campaign by the log's key."""
NEEDED = ("timestamp", "position")
FULL_DUTY = 885
"""Reading of an XL330's amplifier that stands for its whole supply."""
UNSIGNED, SIGN = 1 << 16, 1 << 15
"""The reading has 16 bits in two's complement, logged without their sign."""


def read_bam_log(path: Path) -> list[Recording]:
    """Read a log.

    Parameters
    ----------
    path
        JSON file with the keys ``entries``, ``motor``, ``kp``, ``vin``, ``mass`` and ``length``.

    Returns
    -------
    list of Recording
        The one run.

    Raises
    ------
    InputError
        Where it is no JSON, has no entries, or an entry lacks a number.
    """
    data = read_json(path, WANTED)
    entries = data.get("entries")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries) or not entries:
        got = f"the keys {', '.join(list(data)[:MOST_SHOWN_KEYS]) or 'none'}"
        raise InputError(str(path), expected=f"{WANTED}, with a list of entries", got=got)
    keys = [key for key in NAMES if key in entries[0] or key in NEEDED]
    columns = {NAMES[key]: _column(path, entries, key) for key in keys}
    if str(data.get("motor", "")).lower().startswith("xl330") and "load" in columns:
        load = columns.pop("load")
        columns["duty_0"] = np.where(load >= SIGN, load - UNSIGNED, load) / FULL_DUTY
    return [recording_of(path, columns, about=_about(data), entries="entries")]


def may_be_log(path: Path) -> bool:
    """Whether a JSON file may be a log of BAM.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    bool
        False where it lacks the keys of a log, whatever else it holds, or cannot be read.
    """
    try:
        content = read_content(path, WANTED)
    except InputError:
        return False
    return all(f'"{key}"'.encode() in content for key in ("entries", *NEEDED))


def _column(path: Path, entries: Sequence[Mapping[str, Any]], key: str) -> Array:
    values = np.empty(len(entries))
    for row, entry in enumerate(entries):
        value = entry.get(key)
        if not isinstance(value, bool | int | float):
            where = f"{path}, entries[{row}].{key}"
            raise InputError(where, expected="a number", got="none" if value is None else repr(value))
        values[row] = value
    return values


def _about(data: Mapping[str, Any]) -> str:
    """Say what the log states of its test, which nothing else keeps."""
    known = [f"{key} {data[key]}" for key in ("motor", "kp", "vin", "mass", "length", "trajectory") if key in data]
    return ", ".join(known)
