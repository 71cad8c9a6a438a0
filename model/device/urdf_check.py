"""Checks of a URDF file before its conversion: strict XML, a tree of links, numbers of possible size.

The path of a file comes in, the root element of the checked XML goes out.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from haptid.model.device.urdf_joints import check_joint, link_at
from haptid.model.device.urdf_words import check_depth, check_words
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.files.files import reason_of
from haptid.support.suggestion import did_you_mean

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


def read_urdf(path: Path) -> Element:
    """Read and check a URDF file.

    Parameters
    ----------
    path
        URDF file.

    Returns
    -------
    Element
        Root element ``<robot>``.

    Raises
    ------
    InputError
        At the line of malformed XML, or at the joint or link at fault: misspelt, missing or doubled elements, text in
        place of a number, links that form no tree.
    """
    root = _strict(path)
    if root.tag != "robot":
        raise InputError(str(path), expected="a URDF file, with <robot> around everything", got=f"<{root.tag}>")
    check_words(root, str(path))
    for part in (*root.iterfind("link"), *root.iterfind("joint")):
        check_words(part, _place(path, part))
        _check_numbers(part, _place(path, part))
    for link in root.iterfind("link"):
        _check_inertial(link, _place(path, link))
    _check_tree(path, root)
    joints = {joint.get("name", ""): joint for joint in root.iterfind("joint")}
    for joint in joints.values():
        check_joint(joint, joints, _place(path, joint))
    return root


def _strict(path: Path) -> Element:
    try:
        data = path.read_bytes()
        if re.search(rb"<!(DOCTYPE|ENTITY)", data):
            todo = "take it out: nothing of another file is read"
            raise InputError(str(path), expected="XML without a document type", got="<!DOCTYPE or <!ENTITY", todo=todo)
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        where = f"{path}, line {error.position[0]}"
        raise InputError(where, expected="well-formed XML", got=str(error)) from None
    except (OSError, ValueError, LookupError, RecursionError) as error:
        raise InputError(str(path), expected="a URDF file", got=reason_of(error)) from None
    check_depth(root, str(path))
    return root


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
    if inertial is None:
        return
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        lacking = [name for name, part in (("mass", mass), ("inertia", inertia)) if part is None]
        raise InputError(where, expected="mass and inertia in <inertial>", got=f"no {' and no '.join(lacking)}")
    if float(mass.get("value", 0)) == 0 and any(float(inertia.get(key, 0)) for key in NUMBERS["inertia"]):
        todo = "state the mass, or take <inertial> out"
        raise InputError(where, expected="a mass for a link with inertia", got="mass 0", todo=todo)


def _check_number(text: str, key: str, where: str) -> None:
    if "${" in text:
        raise InputError(where, expected="numbers", got=text, todo="run the file through xacro first")
    words = text.split()
    count = 3 if key in ("xyz", "rpy") else 1
    if len(words) != count or not all(_is_sensible(word) for word in words):
        raise InputError(
            where,
            expected=f"{count} finite number{'s' * (count > 1)} below {THRESHOLDS.largest_value_si:g}",
            got=repr(text),
        )


def _is_sensible(word: str) -> bool:
    try:
        return math.isfinite(float(word)) and abs(float(word)) < THRESHOLDS.largest_value_si and "_" not in word
    except ValueError:
        return False


def _check_tree(path: Path, root: Element) -> None:
    links, joints = list(root.iterfind("link")), list(root.iterfind("joint"))
    for parts in (links, joints):
        _check_distinct(path, parts)
    names = [link.get("name", "") for link in links]
    above: dict[str, Element] = {}
    for joint in joints:
        where = _place(path, joint)
        _check_link(joint, "parent", names, where)
        child = _check_link(joint, "child", names, where)
        if child in above:
            got = f"{child!r}, carried by {above[child].get('name')}"
            raise InputError(where, expected="one joint for every link", got=got)
        above[child] = joint
    roots = [name for name in names if name not in above]
    if len(roots) > 1:
        todo = "join them, or take them out"
        raise InputError(str(path), expected="one link that no joint carries", got=", ".join(roots), todo=todo)
    for joint in joints:
        _check_reached(joint, above, _place(path, joint))


def _check_reached(joint: Element, above: dict[str, Element], where: str) -> None:
    """Check that the parents of a joint lead to the root instead of back to the joint."""
    climbing: Element | None = joint
    for _ in range(len(above) + 1):
        if climbing is None:
            return
        climbing = above.get(link_at(climbing, "parent"))
    got = f"{link_at(joint, 'child')!r} below itself"
    raise InputError(where, expected="a tree of links", got=got, todo="check parent and child")


def _check_distinct(path: Path, parts: list[Element]) -> None:
    names = Counter(part.get("name", "") for part in parts)
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice is not None:
        raise InputError(str(path), expected=f"every {parts[0].tag} once", got=f"{twice!r} twice")


def _check_link(joint: Element, side: str, names: list[str], where: str) -> str:
    link = link_at(joint, side)
    if link not in names:
        place = f"{where}, {side}"
        raise InputError(place, expected="a link of this file", got=repr(link), todo=did_you_mean(link, names))
    return link
