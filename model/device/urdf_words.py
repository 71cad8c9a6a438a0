"""Check of the names in a URDF file: a misspelt element is an error, because a misspelt limit would be no limit.

Other elements (visual, collision, transmission, gazebo, ros2_control, sensor) and attributes of other programs are
ignored, unless their names resemble a known name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from difflib import get_close_matches
from xml.etree.ElementTree import Element

from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.files.data import MOST_NESTED_LEVELS

CHILDREN = {
    "robot": ("link", "joint"),
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "inertial": ("origin", "mass", "inertia"),
}
"""Elements that are read, by their parent element."""
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
"""Required attributes, by element."""
EXTENSIONS = (
    "visual", "collision", "material", "transmission", "gazebo", "sensor", "calibration", "safety_controller",
    "hardwareInterface", "ros2_control", "mujoco", "contact", "loop_joint", "actuator", "frame", "group", "plugin",
)  # fmt: skip
"""Known elements of URDF, Gazebo and other programs that are not read."""


def check_words(element: Element, where: str) -> None:
    """Check the names of an element and of the elements that are read below it.

    Parameters
    ----------
    element
        Element of a URDF.
    where
        Place of the element, for messages.

    Raises
    ------
    InputError
        Where a name is misspelt, a single element stands twice, or a required attribute is missing.
    """
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
    """Check that elements are nested at most `MOST_NESTED_LEVELS` deep.

    Parameters
    ----------
    root
        Root element of a URDF.
    where
        Place of the element, for messages.

    Raises
    ------
    InputError
        Where elements are nested deeper.
    """
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
        if depth > MOST_NESTED_LEVELS:
            raise InputError(where, expected=f"at most {MOST_NESTED_LEVELS} elements within each other", got="more")


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
    near = get_close_matches(name.lower()[:80], list(known), n=1, cutoff=THRESHOLDS.least_share_of_common_letters)
    return near[0] if near else ""


def _plain(tag: object) -> str:
    return tag if isinstance(tag, str) else ""
