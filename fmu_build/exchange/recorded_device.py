"""The device of stored results: names of the user and of the results in, `Device` out, the user's name first."""

from __future__ import annotations

import os
from pathlib import Path

from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.device import Device
from haptid.model.device.reader import builtin_devices, load_device
from haptid.support.errors import InputError


def device_of_results(given: str | None, recorded: str, source: Path) -> Device:
    """Load the device of stored results.

    Parameters
    ----------
    given
        Device that the user names by ``--device``, read from anywhere; None for the recorded one.
    recorded
        Device that the results name: built in, or a file in their own folder.
    source
        File of the results.

    Returns
    -------
    Device
        With its own friction laws.

    Raises
    ------
    InputError
        Where the recorded device is a file elsewhere, or no file. A folder of results may come from a stranger, so a
        file elsewhere is read only where the user names it.
    """
    if given is not None:
        return load_device(given)
    if recorded in builtin_devices():
        return load_device(recorded)
    where, own = f"{source}: device", source.parent.resolve()
    # A name that no path can have counts as the folder itself, which is no file and is refused below.
    possible = recorded.isprintable() and len(recorded) < THRESHOLDS.longest_path_characters
    path = (own / recorded).resolve() if possible else own
    if not path.is_relative_to(own):
        expected, todo = "a built-in name, or a file in the results' own folder", f"--device {recorded} if it is yours"
        raise InputError(where, expected=expected, got=repr(recorded), todo=todo)
    if not os.path.isfile(path):  # noqa: PTH113 # a name that is too long is no file, where Path.is_file raises
        todo = "--device FILE names the device's file"
        raise InputError(where, expected="a built-in name or a file", got=repr(recorded), todo=todo)
    return load_device(path)
