"""Which device a campaign names: a built-in one, ``single_joint``, or a file beside the campaign."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path

from measurement.schema import did_you_mean
from measurement.warning import warn
from support.errors import InputError

SINGLE_JOINT = "single_joint"
BUILT_IN_JOINTS = {"freedom6s": 6, "double_pendulum": 2}


def device_names() -> tuple[str, ...]:
    """Names of the built-in devices: the TOML files of ``model/devices``, and those that are always there."""
    folder = files("model") / "devices"
    found = {item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml")}
    return tuple(sorted(found | {SINGLE_JOINT, *BUILT_IN_JOINTS}))


def resolve_device(device: str, folder: Path, where: str) -> str:
    """Return a built-in name, or the path of the device file.

    A file that does not exist, but bears the name of a built-in device, stands for that device, with a warning.
    """
    if device in device_names():
        return device
    if not device.endswith((".toml", ".urdf")):
        todo = did_you_mean(device, device_names())
        raise InputError(where, expected="a built-in device or a file *.toml", got=repr(device), todo=todo)
    path = folder / device
    if path.is_file():
        return str(path)
    if path.stem in device_names():
        warn(f"{where}: no file {device} in {folder}; the built-in device {path.stem} is used")
        return path.stem
    todo = did_you_mean(path.stem, device_names())
    raise InputError(where, expected="a device file, or a built-in name", got=f"no file {path}", todo=todo)


def joint_count(device: str) -> int | None:
    """Return the number of joints; None for ``single_joint`` and where the device file does not list its joints."""
    if device == SINGLE_JOINT:
        return None
    if device in BUILT_IN_JOINTS:
        return BUILT_IN_JOINTS[device]
    source = Path(device) if device.endswith(".toml") else files("model") / "devices" / f"{device}.toml"
    try:
        joints = tomllib.loads(source.read_text(encoding="utf-8")).get("joints")
    except (OSError, ValueError):
        return None
    return len(joints) if isinstance(joints, list | dict) else None
