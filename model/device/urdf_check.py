"""What a URDF must hold before anything is made of it: strict XML, a tree of links, numbers that mean something."""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from haptid.support.errors import InputError
from haptid.support.files.files import reason_of
from haptid.support.suggestion import did_you_mean

TYPES = ("revolute", "continuous", "prismatic", "fixed")
NUMBERS = {
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "mimic": ("multiplier", "offset"),
}
"""Attributes that hold numbers, by element."""
LARGEST = 1e12
"""No length, mass, torque or angle of a robot is larger in SI units."""


def check_urdf(path: Path) -> None:
    """Refuse a URDF that its parser would repair in silence, or that describes no tree of links.

    Raises
    ------
    InputError
        With the line of malformed XML, or the joint or link at fault.
    """
    root = _strict(path)
    if root.tag != "robot":
        raise InputError(str(path), expected="a URDF file, with <robot> around everything", got=f"<{root.tag}>")
    for part in (*root.iterfind("link"), *root.iterfind("joint")):
        _check_numbers(part, _place(path, part))
    for link in root.iterfind("link"):
        _check_inertial(link, _place(path, link))
    _check_tree(path, root)
    for joint in root.iterfind("joint"):
        _check_joint(joint, _place(path, joint))


def _strict(path: Path) -> Element:
    try:
        data = path.read_bytes()
        if re.search(rb"<!(DOCTYPE|ENTITY)", data):
            todo = "take it out: nothing of another file is read"
            raise InputError(str(path), expected="XML without a document type", got="<!DOCTYPE or <!ENTITY", todo=todo)
        return ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        where = f"{path}, line {error.position[0]}"
        raise InputError(where, expected="well-formed XML", got=str(error)) from None
    except (OSError, ValueError, LookupError, RecursionError) as error:
        raise InputError(str(path), expected="a URDF file", got=reason_of(error)) from None


def _place(path: Path, part: Element) -> str:
    name = part.get("name")
    if not name:
        raise InputError(str(path), expected=f"a name for every {part.tag}", got="one without")
    return f"{path}: {part.tag} {name}"


def _check_numbers(part: Element, where: str) -> None:
    for element in part.iter():
        for key in NUMBERS.get(element.tag, ()):
            text = element.get(key)
            if text is not None:
                _check_number(text, key, f"{where}, {element.tag} {key}")


def _check_inertial(link: Element, where: str) -> None:
    inertial = link.find("inertial")
    lacking = [] if inertial is None else [name for name in ("mass", "inertia") if inertial.find(name) is None]
    if lacking:
        raise InputError(where, expected="mass and inertia in <inertial>", got=f"no {' and no '.join(lacking)}")


def _check_number(text: str, key: str, where: str) -> None:
    if "${" in text:
        raise InputError(where, expected="numbers", got=text, todo="run the file through xacro first")
    words = text.split()
    count = 3 if key in ("xyz", "rpy") else 1
    if len(words) != count or not all(_is_sensible(word) for word in words):
        raise InputError(where, expected=f"{count} finite number{'s' * (count > 1)} below {LARGEST:g}", got=repr(text))


def _is_sensible(word: str) -> bool:
    try:
        return math.isfinite(float(word)) and abs(float(word)) < LARGEST
    except ValueError:
        return False


def _check_tree(path: Path, root: Element) -> None:
    links, joints = list(root.iterfind("link")), list(root.iterfind("joint"))
    for parts in (links, joints):
        _check_distinct(path, parts)
    names = [link.get("name", "") for link in links]
    carried: dict[str, str] = {}
    for joint in joints:
        where = _place(path, joint)
        _linked(joint, "parent", names, where)
        child = _linked(joint, "child", names, where)
        if child in carried:
            got = f"{child!r}, carried by {carried[child]}"
            raise InputError(where, expected="one joint for every link", got=got)
        carried[child] = joint.get("name", "")
    roots = [name for name in names if name not in carried]
    if len(roots) > 1:
        raise InputError(str(path), expected="one link that no joint carries", got=", ".join(roots))


def _check_distinct(path: Path, parts: list[Element]) -> None:
    names = Counter(part.get("name", "") for part in parts)
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice is not None:
        raise InputError(str(path), expected=f"every {parts[0].tag} once", got=f"{twice!r} twice")


def _linked(joint: Element, side: str, names: list[str], where: str) -> str:
    element = joint.find(side)
    link = "" if element is None else element.get("link", "")
    if link not in names:
        place = f"{where}, {side}"
        raise InputError(place, expected="a link of this file", got=repr(link), todo=did_you_mean(link, names))
    return link


def _check_joint(joint: Element, where: str) -> None:
    kind = joint.get("type", "")
    if kind not in TYPES:
        raise InputError(where, expected=" or ".join(TYPES), got=f"type {kind!r}", todo=did_you_mean(kind, TYPES))
    axis = joint.find("axis")
    if axis is not None and not any(float(word) for word in axis.get("xyz", "1 0 0").split()):
        raise InputError(where, expected="an axis with a direction", got=repr(axis.get("xyz")))
    limit = joint.find("limit")
    if limit is None:
        return
    lower, upper, effort = (float(limit.get(key, 0.0)) for key in ("lower", "upper", "effort"))
    if lower > upper:
        raise InputError(where, expected="limits with lower <= upper", got=f"lower {lower}, upper {upper}")
    if effort < 0:
        raise InputError(where, expected="an effort of 0 or more", got=str(effort))
