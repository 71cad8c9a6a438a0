"""The device of results that are read again: the one that the user names, else the one that the results name."""

from __future__ import annotations

import os
from pathlib import Path

from haptid.model.device.device import Device
from haptid.model.device.reader import builtin_devices, load_device
from haptid.support.errors import InputError

LONGEST_PATH = 1024
"""Characters of a device's path; the shortest limit among the systems, macOS's."""


def device_of_results(given: str | None, recorded: str, source: Path) -> Device:
    """Return the device that the user names, else the recorded one, built in or from the results' own folder.

    A folder of results may come from a stranger: what it names elsewhere is read only where the user says so.
    """
    if given is not None:
        return load_device(given)
    if recorded in builtin_devices():
        return load_device(recorded)
    where, own = f"{source}: device", source.parent.resolve()
    path = (own / recorded).resolve() if recorded.isprintable() and len(recorded) < LONGEST_PATH else own
    if not path.is_relative_to(own):
        expected, todo = "a built-in name, or a file in the results' own folder", f"--device {recorded} if it is yours"
        raise InputError(where, expected=expected, got=repr(recorded), todo=todo)
    if not os.path.isfile(path):  # noqa: PTH113 # a name that is too long is no file, where Path.is_file raises
        todo = "--device FILE names the device's file"
        raise InputError(where, expected="a built-in name or a file", got=repr(recorded), todo=todo)
    return load_device(path)
