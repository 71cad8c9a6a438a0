"""The device of a campaign: resolve its name to a built-in one, ``single_joint`` or a path; load it as `Device`."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree

from haptid.measurement.format.places import check_inside
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warn
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.support.errors import InputError
from haptid.support.files.files import is_file
from haptid.support.suggestion import did_you_mean

SINGLE_JOINT = "single_joint"
SUFFIXES = (".toml", ".urdf")


def device_names() -> tuple[str, ...]:
    """List the devices that a campaign can name without a file.

    Returns
    -------
    tuple of str
        Names of the built-in devices (the TOML files of ``model/device/built_in``) and ``single_joint``, in
        alphabetical order.
    """
    folder = files("haptid.model.device") / "built_in"
    found = {item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml")}
    return tuple(sorted(found | {SINGLE_JOINT}))


def resolve_device(device: str, folder: Path, where: str) -> str:
    """Return a built-in name, or the path of the device file.

    Parameters
    ----------
    device
        As ``campaign.toml`` names it.
    folder
        Folder of the campaign, from which a relative path starts.
    where
        Place of the name in ``campaign.toml``, for errors and warnings.

    Returns
    -------
    str
        A built-in name, or ``folder`` joined with the file. A file that does not exist but has the name of a built-in
        device stands for that device.

    Raises
    ------
    InputError
        Where there is no such device or file, or the file lies outside ``folder`` without ``--allow-outside``.

    Warns
    -----
    CampaignWarning
        Where a built-in device replaces a missing file.
    """
    if device in device_names():
        return device
    if not device.endswith(SUFFIXES):
        todo = did_you_mean(device, device_names())
        raise InputError(where, expected="a built-in device or a file *.toml, *.urdf", got=repr(device), todo=todo)
    path = folder / device
    if is_file(path):
        check_inside(folder, device, where)
        return str(path)
    if path.stem in device_names():
        warn(f"{where}: no file {device} in {folder}; the built-in device {path.stem} is used")
        return path.stem
    todo = did_you_mean(path.stem, device_names())
    raise InputError(where, expected="a device file, or a built-in name", got=f"no file {path.name} there", todo=todo)


def joint_count(device: str) -> int | None:
    """Count the joints of a device without loading it.

    Parameters
    ----------
    device
        As `resolve_device` returns it.

    Returns
    -------
    int or None
        Number of joints. None for ``single_joint``, and for a file that cannot be read or lists no joints:
        `load_device` states its fault later.
    """
    if device == SINGLE_JOINT:
        return None
    is_file = device.endswith(SUFFIXES)
    source = Path(device) if is_file else files("haptid.model.device") / "built_in" / f"{device}.toml"
    try:
        text = source.read_text(encoding="utf-8")
        return _urdf_joints(text) if device.endswith(".urdf") else _toml_joints(text)
    except (OSError, ValueError, RecursionError, ElementTree.ParseError):
        return None


def _toml_joints(text: str) -> int | None:
    joints = tomllib.loads(text).get("joints")
    return len(joints) if isinstance(joints, list) else None


def _urdf_joints(text: str) -> int:
    joints = ElementTree.fromstring(text).findall("joint")
    moving = ("revolute", "continuous", "prismatic")
    return sum(joint.get("type") in moving and joint.find("mimic") is None for joint in joints)


def joint_range(count: int) -> str:
    """Say which joints a device with ``count`` joints has: ``0 to 5``, or that it has none.

    Parameters
    ----------
    count
        Number of joints that move.

    Returns
    -------
    str
        Words for an error message.
    """
    return f"0 to {count - 1}" if count else "which has no joint that moves"


def device_of(campaign: Campaign) -> Device | None:
    """Load the campaign's device with the friction laws that the campaign names.

    Parameters
    ----------
    campaign
        Campaign with the name of its device and the friction law by joint.

    Returns
    -------
    Device or None
        None for ``single_joint``.

    Raises
    ------
    InputError
        Where the file of the device is missing or at fault.
    """
    if campaign.device == SINGLE_JOINT:
        return None
    device = campaign.loaded or load_device(campaign.device, campaign.folder)
    return device.with_friction(campaign.friction)
