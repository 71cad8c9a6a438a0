"""What the user states of the tables: flags or replies in, checked values out."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from haptid.measurement.format.devices import SINGLE_JOINT, SUFFIXES, device_names
from haptid.measurement.naming.mapping import Target
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.support.errors import InputError
from haptid.support.files.files import is_file
from haptid.support.suggestion import did_you_mean

VALIDATION = re.compile(r"(^|[^a-z])(val|valid|validate|validation|unseen|holdout|hold_out)([^a-z]|$)")
"""Words of a file's name that say that no fit shall see the run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """Hold the user's statements on the data, from flags or from answers to questions.

    Parameters
    ----------
    title
        One line that names the tests.
    device
        Built-in name, device file, ``single_joint``, or the device itself.
    measured
        False for synthetic data.
    hold
        Torque between rows, ``zero`` or ``linear``.
    noise
        Standard deviation of the white sensor noise [rad] ([m]); None to estimate it.
    resolution
        Encoder step [rad] ([m]); None to estimate it.
    validate
        Names of the tables that validate.
    free
        Joints that move; None for those that do in each table.
    stated
        Column of the format by column of the user's tables, as the user states it.
    closed
        Joints whose controller the user states.
    torque_constant
        Torque of an ampere [N m/A] ([N/A] where a joint slides), of the joints whose current, voltage or duty was
        recorded in place of the torque; None where it is not stated.
    resistance
        Resistance of the winding [ohm], of the joints whose voltage or duty was recorded; None where it is not stated.
    supply
        Voltage of which a recorded duty is a share [V], in tables without a column of it; None where it is not stated.
    """

    title: str
    device: str | Device
    measured: bool
    hold: str
    noise: float | None
    resolution: float | None
    validate: tuple[str, ...]
    free: tuple[int, ...] | None
    stated: Mapping[str, Target]
    closed: frozenset[int] = frozenset()
    torque_constant: float | None = None
    resistance: float | None = None
    supply: float | None = None


def device_of(answers: Answers) -> Device | None:
    """Return the device that the user states.

    Parameters
    ----------
    answers
        What the user states.

    Returns
    -------
    Device or None
        None for a single joint.
    """
    if answers.device == SINGLE_JOINT:
        return None
    return answers.device if isinstance(answers.device, Device) else load_device(answers.device)


def propose_device(folder: Path) -> str:
    """Propose a device: the file of one that lies among the tables, where there is exactly one.

    Parameters
    ----------
    folder
        Folder of the tables.

    Returns
    -------
    str
        Name of the file, or ``single_joint``.
    """
    files = sorted(path.name for path in folder.iterdir() if path.name.endswith(SUFFIXES) and is_file(path))
    files = [name for name in files if name != "campaign.toml"]
    return files[0] if len(files) == 1 else SINGLE_JOINT


def propose_validation(names: Sequence[str]) -> tuple[str, ...]:
    """Propose the runs that are kept from every fit: those whose names say so, as long as others are left.

    Parameters
    ----------
    names
        Names of all tables.

    Returns
    -------
    tuple of str
        In the order of ``names``; empty where no name says so.
    """
    chosen = tuple(name for name in names if VALIDATION.search(name.lower()))
    return chosen if len(chosen) < len(names) else ()


def select_runs(patterns: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """Return the tables that names or patterns such as ``val_*.csv`` select.

    Parameters
    ----------
    patterns
        Values of ``--validate``.
    names
        Names of all tables.

    Returns
    -------
    tuple of str
        In the order of ``names``.

    Raises
    ------
    InputError
        Where a pattern selects none, or all tables are selected.
    """
    chosen: set[str] = set()
    for pattern in patterns:
        fitting = {name for name in names if _fits(name, pattern)}
        # The run of sweep.mat is sweep.csv in the campaign; the user knows the name of the recording.
        fitting = fitting or {name for name in names if _fits(_stem(name), _stem(pattern))}
        if not fitting:
            raise InputError("--validate", expected=f"one of {', '.join(sorted(names))}", got=pattern)
        chosen |= fitting
    if chosen.issuperset(names) and names:
        todo = "leave at least one run to be fitted"
        raise InputError("--validate", expected="some of the runs", got=f"all of them ({', '.join(names)})", todo=todo)
    return tuple(name for name in names if name in chosen)


def _fits(name: str, pattern: str) -> bool:
    return name == pattern or fnmatchcase(name, pattern)


def _stem(name: str) -> str:
    """Return a name without the end that tells the kind of file."""
    return Path(name).stem.removesuffix(".csv")


def find_device(device: str, folder: Path) -> str:
    """Find a device by built-in name, or its file from here or from the folder of the tables.

    Parameters
    ----------
    device
        As the user names it.
    folder
        Folder of the tables.

    Returns
    -------
    str
        Built-in name, or path of the file. A file that is not there but has the name of a built-in device is returned
        as it is.

    Raises
    ------
    InputError
        Where there is no such device or file.
    """
    if device in device_names():
        return device
    if not device.endswith(SUFFIXES):
        expected, todo = "a built-in device or a file *.toml, *.urdf", did_you_mean(device, device_names())
        raise InputError("device", expected=expected, got=repr(device), todo=todo)
    for path in (Path(device), folder / device):
        if is_file(path):
            return str(path)
    if Path(device).stem in device_names():
        return device
    got = f"no {device} here and none in {folder}"
    raise InputError("device", expected=f"a file, or one of {', '.join(device_names())}", got=got)
