"""Read a URDF file: the path of the file in, the same `Device` out that a TOML file would give.

1. Check the XML, its tree of links and its numbers (`read_urdf`).
2. Order joints so that parents come first, and number the driven ones in the order of the file: fixed and mimicking
   joints have no number, a mimicking joint becomes a passive link, the root link becomes the base.
3. Convert links and joints to the table of a device file, friction and damping to first guesses.
4. Parse the table (`parse_device`); messages name keys by their URDF names.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from haptid.model.device.device import BASE, Device
from haptid.model.device.device_table import parse_device
from haptid.model.device.urdf_check import read_urdf
from haptid.model.device.urdf_joints import friction_guesses, link_at, number
from haptid.support.errors import InputError
from haptid.support.files.place import KeyPath, Place, join_path

MOTIONS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}
OF_THE_LINK = {"mass": "mass value", "centroid": "inertial origin", "inertia": "inertia", "name": "name"}
OF_THE_JOINT = {"origin": "origin xyz", "rpy": "origin rpy", "axis": "axis xyz", "moved_by": "mimic"}
OF_THE_DRIVE = {"position_limits": "limit", "torque_limit": "limit effort", "parameters": "dynamics"}
"""URDF names of the keys of a device's table, below link or joint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Robot:
    """A checked URDF: its joints from the root down, those that are driven, and its links by name."""

    name: str
    joints: tuple[Element, ...]
    driven: tuple[Element, ...]
    links: dict[str, Element]


def load_urdf(path: Path) -> Device:
    """Load a device from a URDF file; meshes are not read.

    Parameters
    ----------
    path
        URDF file.

    Returns
    -------
    Device
        The checked device; the control point is the origin of the last link.

    Raises
    ------
    InputError
        Where the file is malformed, has no moving joint, or describes no possible device.
    """
    root = read_urdf(path)
    joints = list(root.iterfind("joint"))
    driven = tuple(joint for joint in joints if joint.get("type") != "fixed" and joint.find("mimic") is None)
    if not driven:
        raise InputError(str(path), expected="a moving joint", got="none")
    robot = _Robot(
        name=root.get("name") or path.stem,
        joints=_downwards(joints),
        driven=driven,
        links={_name(link): link for link in root.iterfind("link")},
    )
    names = _names([link_at(joint, "child") for joint in robot.joints])
    table = {
        "name": _identifier(robot.name),
        "title": f"{robot.name} (from {path.name})",
        "assumptions": [f"Everything from {path.name}; friction and limits where it gives them."],
        "joints": [_drive(joint) for joint in robot.driven],
        "links": [_link(joint, robot, names) for joint in robot.joints],
        "control_point": {"link": names[link_at(robot.joints[-1], "child")], "position": [0.0, 0.0, 0.0]},
    }
    return parse_device(table, Place(file=str(path), words=lambda key: _words(key, robot)))


def _words(path: KeyPath, robot: _Robot) -> str:
    """Return the URDF name of a key of the table, as ``link upper, mass value``."""
    if len(path) < 2 or not isinstance(path[1], int):
        return join_path(path)
    key = str(path[2]) if len(path) > 2 else ""
    if path[0] == "joints":
        owner, names = f"joint {_name(robot.driven[path[1]])}", OF_THE_DRIVE
    elif key in OF_THE_LINK:
        owner, names = f"link {link_at(robot.joints[path[1]], 'child')}", OF_THE_LINK
    else:
        owner, names = f"joint {_name(robot.joints[path[1]])}", OF_THE_JOINT
    return f"{owner}, {names.get(key, key)}" if key else owner


def _name(element: Element) -> str:
    return element.get("name", "")


def _identifier(name: str) -> str:
    clean = re.sub(r"\W", "_", name, flags=re.ASCII)
    return clean if clean[:1].isalpha() else f"r_{clean}"


def _names(links: Sequence[str]) -> dict[str, str]:
    """Return a name of its own for each link, of letters, digits and _; ``l-1`` and ``l_1`` become two."""
    result: dict[str, str] = {}
    for link in links:
        stem = candidate = _identifier(link)
        count = 1
        while candidate in (BASE, *result.values()):
            count += 1
            candidate = f"{stem}_{count}"
        result[link] = candidate
    return result


def _downwards(joints: Sequence[Element]) -> tuple[Element, ...]:
    """Return the joints so that parents come first, in the file's order where that allows."""
    left, result = list(joints), []
    while left:
        # a joint is ready where no remaining joint carries its parent; the checked tree always has one
        below = {link_at(joint, "child") for joint in left}
        ready = next(joint for joint in left if link_at(joint, "parent") not in below)
        result.append(ready)
        left.remove(ready)
    return tuple(result)


def _drive(joint: Element) -> dict[str, Any]:
    kind, limit = joint.get("type"), joint.find("limit")
    entry: dict[str, Any] = {"name": _name(joint), "prismatic": kind == "prismatic"}
    if kind != "continuous":
        entry["position_limits"] = [number(limit, "lower"), number(limit, "upper")]
    if limit is not None:
        entry["torque_limit"] = number(limit, "effort")
    return entry | {"parameters": {"Kp": {"fixed": 1.0}} | friction_guesses(joint)}


def _link(joint: Element, robot: _Robot, names: dict[str, str]) -> dict[str, Any]:
    origin, kind = joint.find("origin"), joint.get("type", "")
    entry: dict[str, Any] = {
        "name": names[link_at(joint, "child")],
        "title": _name(joint),
        "parent": names.get(link_at(joint, "parent"), BASE),
        "motion": MOTIONS[kind],
        "origin": _triple(origin, "xyz"),
        "rpy": _triple(origin, "rpy"),
    }
    if kind != "fixed":
        axis = joint.find("axis")
        entry["axis"] = [1.0, 0.0, 0.0] if axis is None else _triple(axis, "xyz")
        entry["moved_by"] = _moved_by(joint, [_name(other) for other in robot.driven])
    return entry | _inertial(robot.links[link_at(joint, "child")].find("inertial"))


def _triple(element: Element | None, key: str) -> list[float]:
    text = None if element is None else element.get(key)
    return [0.0, 0.0, 0.0] if text is None else [float(word) for word in text.split()]


def _moved_by(joint: Element, driven: Sequence[str]) -> dict[str, float]:
    mimic = joint.find("mimic")
    if mimic is None:
        return {str(driven.index(_name(joint))): 1}
    multiplier = number(mimic, "multiplier", 1.0)
    place = driven.index(mimic.get("joint", ""))
    return {str(place): int(multiplier) if multiplier.is_integer() else multiplier}


def _inertial(inertial: Element | None) -> dict[str, Any]:
    if inertial is None or not number(inertial.find("mass"), "value"):
        return {}
    origin, inertia = inertial.find("origin"), inertial.find("inertia")
    R = rotation(_triple(origin, "rpy"))
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    tensor = np.zeros((3, 3))
    for key, (i, j) in pairs.items():
        tensor[i, j] = tensor[j, i] = number(inertia, f"i{key}")
    # a URDF states the tensor in the axes of <inertial>, a device in the axes of the link
    tensor = R @ tensor @ R.T
    return {
        "mass": number(inertial.find("mass"), "value"),
        "centroid": _triple(origin, "xyz"),
        "inertia": {f"I{i + 1}{j + 1}": float(tensor[i, j]) for i, j in pairs.values()},
    }


def rotation(rpy: Sequence[float]) -> NDArray[np.float64]:
    """Return the rotation of fixed-axis angles.

    Parameters
    ----------
    rpy
        Roll, pitch, yaw [rad], shape (3,).

    Returns
    -------
    Array
        R = Rz(yaw)·Ry(pitch)·Rx(roll), shape (3, 3).
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
