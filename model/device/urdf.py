"""URDF in: the same device that a TOML file would give.

Joints are numbered in the order of the file, without fixed and mimicking ones; a mimicking joint becomes a passive
link.
The root link stands still. Friction and damping of the file, where given, become first guesses.
"""

from __future__ import annotations

import math
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.model.device.device import BASE, Device
from haptid.model.device.reader import parse_device
from haptid.model.device.urdf_check import check_urdf
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.support.errors import InputError
from haptid.support.installing.extras import need

STICTION = 1.2
"""First guess of stiction over Coulomb friction, of which a URDF file gives one number."""
MOTIONS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}


def load_urdf(path: Path) -> Device:
    """Return the device of a URDF file; meshes are not needed."""
    check_urdf(path)
    robot = _parse(path)
    links = {link.name: link for link in robot.links}
    children = {joint.child for joint in robot.joints}
    actuated = [joint for joint in robot.joints if joint.type != "fixed" and joint.mimic is None]
    numbers = {joint.name: number for number, joint in enumerate(actuated)}
    root = next((name for name in links if name not in children), None)
    if root is None or not actuated:
        raise InputError(str(path), expected="a tree with a root link and a moving joint", got="none")
    entries = [_link(joint, links[joint.child], root, numbers, path) for joint in _downwards(robot.joints, root)]
    table = {
        "name": _identifier(robot.name or path.stem),
        "title": f"{robot.name or path.stem} (from {path.name})",
        "assumptions": [f"Everything from {path.name}; friction and limits where it gives them."],
        "joints": [_joint(joint) for joint in actuated],
        "links": entries,
        "control_point": {"link": entries[-1]["name"], "position": [0.0, 0.0, 0.0]},
    }
    return parse_device(table, str(path))


def _parse(path: Path) -> Any:
    need("urdf", str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # trimesh's and lxml's own deprecations are not the user's concern
        from yourdfpy import URDF  # noqa: PLC0415 (slow to import, needed for URDF files alone)

        try:
            return URDF.load(
                str(path), build_scene_graph=False, build_collision_scene_graph=False, load_meshes=False
            ).robot
        except Exception as error:  # the library raises whatever the XML parser and its own code raise
            raise InputError(str(path), expected="a URDF file", got=f"{type(error).__name__}: {error}") from None


def _identifier(name: str) -> str:
    clean = re.sub(r"\W", "_", name)
    return clean if clean[:1].isalpha() else f"r_{clean}"


def _downwards(joints: list[Any], root: str) -> list[Any]:
    """Return the joints so that parents come first, in the file's order where that allows."""
    known, left, result = {root}, list(joints), []
    while left:
        ready = [joint for joint in left if joint.parent in known]
        if not ready:
            break
        result.append(ready[0])
        known.add(ready[0].child)
        left.remove(ready[0])
    return result


def _joint(joint: Any) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": joint.name, "prismatic": joint.type == "prismatic"}
    limit, dynamics = joint.limit, joint.dynamics
    if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
        entry["position_limits"] = [float(limit.lower), float(limit.upper)]
    if limit is not None and limit.effort:
        entry["torque_limit"] = float(limit.effort)
    guesses, roles = {"Kp": {"fixed": 1.0}}, law_named(DEFAULT).roles
    if dynamics is not None and dynamics.damping:
        guesses[roles.viscous] = {"initial": float(dynamics.damping)}
    if dynamics is not None and dynamics.friction:
        guesses[roles.stiction] = {"initial": STICTION * float(dynamics.friction)}
        guesses[roles.coulomb] = {"initial": float(dynamics.friction)}
    return entry | {"parameters": guesses}


def _link(joint: Any, link: Any, root: str, numbers: dict[str, int], path: Path) -> dict[str, Any]:
    if joint.type not in MOTIONS:
        raise InputError(where=f"{path}: joint {joint.name}", expected=" or ".join(MOTIONS), got=repr(joint.type))
    origin = np.eye(4) if joint.origin is None else joint.origin
    entry = {
        "name": _identifier(link.name),
        "title": joint.name,
        "parent": BASE if joint.parent == root else _identifier(joint.parent),
        "motion": MOTIONS[joint.type],
        "origin": origin[:3, 3].tolist(),
        "rpy": roll_pitch_yaw(origin[:3, :3]),
    }
    if joint.type != "fixed":
        entry["axis"] = [1.0, 0.0, 0.0] if joint.axis is None else [float(x) for x in joint.axis]
        entry["moved_by"] = _moved_by(joint, numbers, path)
    return entry | _inertial(link)


def _moved_by(joint: Any, numbers: dict[str, int], path: Path) -> dict[str, float]:
    if joint.mimic is None:
        return {str(numbers[joint.name]): 1}
    if joint.mimic.joint not in numbers or joint.mimic.offset:
        got = f"{joint.mimic.joint} with offset {joint.mimic.offset}"
        raise InputError(where=f"{path}: joint {joint.name}, mimic", expected="a moving joint and no offset", got=got)
    multiplier = float(joint.mimic.multiplier)
    return {str(numbers[joint.mimic.joint]): int(multiplier) if multiplier.is_integer() else multiplier}


def _inertial(link: Any) -> dict[str, Any]:
    if link.inertial is None or not link.inertial.mass:
        return {}
    origin = np.eye(4) if link.inertial.origin is None else link.inertial.origin
    R = origin[:3, :3]
    tensor = R @ np.asarray(link.inertial.inertia, dtype=np.float64) @ R.T
    pairs = {"I11": (0, 0), "I22": (1, 1), "I33": (2, 2), "I12": (0, 1), "I13": (0, 2), "I23": (1, 2)}
    return {
        "mass": float(link.inertial.mass),
        "centroid": origin[:3, 3].tolist(),
        "inertia": {key: float(tensor[index]) for key, index in pairs.items()},
    }


def roll_pitch_yaw(R: NDArray[np.float64]) -> list[float]:
    """Return fixed-axis angles of R = Rz(yaw)·Ry(pitch)·Rx(roll); at pitch ±π/2 the roll is 0."""
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if abs(abs(pitch) - math.pi / 2) < 1e-9:
        return [0.0, pitch, math.atan2(-R[0, 1], R[1, 1])]
    return [math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])]
