"""The device of stored results: names of the user and of the results in, `Device` out, the user's name first."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.device import Device
from haptid.model.device.reader import builtin_devices, load_device
from haptid.support.errors import InputError

COPY_OF_DEVICE = "device_file"
"""Key of identification.json with the copy of the device's file in the results' own folder."""


def device_of_results(given: str | None, data: Mapping[str, Any], source: Path) -> Device:
    """Load the device of stored results.

    Parameters
    ----------
    given
        Device that the user names by ``--device``, read from anywhere; None for the recorded one.
    data
        Content of the results, which name the device: built in, or a file, of which their own folder has a copy.
    source
        File of the results.

    Returns
    -------
    Device
        With its own friction laws.

    Raises
    ------
    InputError
        Where the recorded device is a file elsewhere without a copy, or no file. A folder of results may come from a
        stranger, so a file elsewhere is read only where the user names it.
    """
    if given is not None:
        return load_device(given)
    recorded = data["device"]
    if recorded in builtin_devices():
        return load_device(recorded)
    where, own = f"{source}: device", source.parent.resolve()
    copy = _path_in(own, data.get(COPY_OF_DEVICE, ""))
    if copy.is_relative_to(own) and os.path.isfile(copy):  # noqa: PTH113 # as below
        return load_device(copy)
    path = _path_in(own, recorded)
    if not path.is_relative_to(own):
        expected, todo = "a built-in name, or a file in the results' own folder", f"--device {recorded} if it is yours"
        raise InputError(where, expected=expected, got=repr(recorded), todo=todo)
    if not os.path.isfile(path):  # noqa: PTH113 # a name that is too long is no file, where Path.is_file raises
        todo = "--device FILE names the device's file"
        raise InputError(where, expected="a built-in name or a file", got=repr(recorded), todo=todo)
    return load_device(path)


def _path_in(own: Path, name: str) -> Path:
    """Return where a name leads from a folder; one that no path can have, to the folder itself, which is no file."""
    possible = name.isprintable() and len(name) < THRESHOLDS.longest_path_characters
    return (own / name).resolve() if possible else own
