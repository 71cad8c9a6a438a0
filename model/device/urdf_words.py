"""The elements and attributes of a URDF that are read, and the misspelt ones: a misspelt limit would be no limit.

Whatever else stands in a file (visual, collision, transmission, gazebo, ros2_control, sensor, an attribute of another
program) is left alone, unless its name is nearly one of those that are read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from difflib import get_close_matches
from xml.etree.ElementTree import Element

from haptid.support.errors import InputError
from haptid.support.files.data import DEEPEST

CHILDREN = {
    "robot": ("link", "joint"),
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "inertial": ("origin", "mass", "inertia"),
}
"""Elements that are read, by the one around them."""
REPEATED = ("link", "joint")
"""Elements that may stand several times."""
ATTRIBUTES = {
    "robot": ("name",),
    "link": ("name",),
    "joint": ("name", "type"),
    "origin": ("xyz", "rpy"),
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "mimic": ("joint", "multiplier", "offset"),
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
}
"""Attributes that are read."""
REQUIRED = {
    "parent": ("link",),
    "child": ("link",),
    "axis": ("xyz",),
    "mimic": ("joint",),
    "mass": ("value",),
    "inertia": ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"),
}
"""Attributes without which an element says nothing."""
EXTENSIONS = (
    "visual", "collision", "material", "transmission", "gazebo", "sensor", "calibration", "safety_controller",
    "hardwareInterface", "ros2_control", "mujoco", "contact", "loop_joint", "actuator", "frame", "group", "plugin",
)  # fmt: skip
"""Elements that URDF, Gazebo and others have beside those that are read."""
ALIKE = 0.6
"""Share of common letters from which a name is taken for a misspelling (``xzy`` for ``xyz`` has two thirds)."""


def check_words(element: Element, where: str) -> None:
    """Refuse misspelt names, a second element where one may stand, and missing attributes, of one element and below."""
    _check_names(element, where)
    known = CHILDREN.get(_plain(element.tag), ())
    for child in element:
        if child.tag in known and child.tag not in REPEATED:
            check_words(child, f"{where}, {child.tag}")
    counts = Counter(child.tag for child in element)
    twice = next((name for name in known if counts[name] > 1 and name not in REPEATED), None)
    if twice is not None:
        raise InputError(where, expected=f"one <{twice}>", got=f"{counts[twice]}")


def check_depth(root: Element, where: str) -> None:
    """Refuse an element within more others than any robot has."""
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
        if depth > DEEPEST:
            raise InputError(where, expected=f"at most {DEEPEST} elements within each other", got="more")


def _check_names(element: Element, where: str) -> None:
    tag = _plain(element.tag)
    known = CHILDREN.get(tag, ())
    for name in (child.tag for child in element):
        near = _misspelt(name, known) if name not in EXTENSIONS else ""
        if near:
            raise InputError(where, expected="elements of a URDF", got=f"<{name}>", todo=f"did you mean <{near}>?")
    allowed = ATTRIBUTES.get(tag, ())
    for name in element.keys():  # noqa: SIM118 (an element is no dictionary)
        near = _misspelt(name, allowed)
        if near:
            raise InputError(where, expected=f"attributes of <{tag}>", got=repr(name), todo=f"did you mean {near!r}?")
    lacking = [name for name in REQUIRED.get(tag, ()) if element.get(name) is None]
    if lacking:
        raise InputError(where, expected=f"<{tag}> with {', '.join(REQUIRED[tag])}", got=f"no {', '.join(lacking)}")


def _misspelt(name: object, known: Iterable[str]) -> str:
    """Return the known name that another one nearly is; "" for known names, comments and names with a namespace."""
    if not isinstance(name, str) or name in known or name.startswith("{") or ":" in name:
        return ""
    near = get_close_matches(name.lower()[:80], list(known), n=1, cutoff=ALIKE)
    return near[0] if near else ""


def _plain(tag: object) -> str:
    return tag if isinstance(tag, str) else ""
