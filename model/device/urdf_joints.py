"""Checks of the joints of a URDF: type, axis, limits, friction, and the joint that a mimicking joint follows."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from haptid.model.device.stated_parameters import check_parameters
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

TYPES = ("revolute", "continuous", "prismatic", "fixed")


def link_at(joint: Element, side: str) -> str:
    """Return the link at one side of a joint.

    Parameters
    ----------
    joint
        Element ``joint`` of a URDF.
    side
        ``parent`` or ``child``.

    Returns
    -------
    str
        Name of the link; empty where the joint does not say.
    """
    element = joint.find(side)
    return "" if element is None else element.get("link", "")


def number(element: Element | None, key: str, default: float = 0.0) -> float:
    """Return a numeric attribute of an element.

    Parameters
    ----------
    element
        Checked element; None where the file has none.
    key
        Name of the attribute.
    default
        Default of the URDF format.

    Returns
    -------
    float
        The number, or the default where element or attribute is missing.
    """
    text = None if element is None else element.get(key)
    return default if text is None else float(text)


def friction_guesses(joint: Element) -> dict[str, dict[str, float]]:
    """Convert ``<dynamics>`` of a joint to first guesses of friction.

    Parameters
    ----------
    joint
        Checked ``<joint>`` element.

    Returns
    -------
    dict of str to dict of str to float
        Entries ``{"initial": value}`` by parameter id of the default friction law; none for a value of 0, by which URDF
        files state that friction is unknown.
    """
    dynamics = joint.find("dynamics")
    damping, friction = number(dynamics, "damping"), number(dynamics, "friction")
    roles = law_named(DEFAULT).roles
    viscous = {roles.viscous: {"initial": damping}} if damping else {}
    dry = (
        {roles.coulomb: {"initial": friction}, roles.stiction: {"initial": THRESHOLDS.stiction_over_coulomb * friction}}
        if friction
        else {}
    )
    return viscous | dry


def check_joint(joint: Element, joints: dict[str, Element], where: str) -> None:
    """Check one joint of a URDF.

    Parameters
    ----------
    joint
        Element of the joint.
    joints
        Elements of all joints of the file, by name.
    where
        Place of the joint, for messages.

    Raises
    ------
    InputError
        Where type or axis are wrong, a required limit is missing or leaves no motion or no effort, friction is
        impossible, or the joint mimics a joint that is not driven.
    """
    kind = joint.get("type", "")
    if kind not in TYPES:
        raise InputError(where, expected=" or ".join(TYPES), got=f"type {kind!r}", todo=did_you_mean(kind, TYPES))
    axis = joint.find("axis")
    if axis is not None and kind != "fixed" and not any(float(word) for word in axis.get("xyz", "").split()):
        raise InputError(where, expected="an axis with a direction", got=repr(axis.get("xyz")))
    mimic = joint.find("mimic")
    if kind != "fixed" and mimic is None:
        _check_limit(joint.find("limit"), kind, where)
        roles = law_named(DEFAULT).roles
        stiction = f"friction (stiction is {THRESHOLDS.stiction_over_coulomb} times it)"
        names = {roles.viscous: "damping", roles.coulomb: "friction", roles.stiction: stiction}
        check_parameters(friction_guesses(joint), lambda id: f"{where}, dynamics {names[id]}")
    if kind != "fixed" and mimic is not None:
        _check_mimic(mimic, kind, joints, f"{where}, mimic")


def _check_limit(limit: Element | None, kind: str, where: str) -> None:
    if limit is None:
        if kind == "continuous":
            return
        todo = 'URDF demands it: <limit lower="…" upper="…" effort="…" velocity="…"/>, or type continuous'
        raise InputError(where, expected=f"a <limit> of a {kind} joint", got="none", todo=todo)
    lower, upper = number(limit, "lower"), number(limit, "upper")
    if kind != "continuous" and not lower < upper:
        stated = "" if limit.get("lower") and limit.get("upper") else " (0 where not stated)"
        got = f"lower {lower}, upper {upper}{stated}"
        raise InputError(where, expected="limits with lower < upper", got=got, todo="a joint that stands is fixed")
    effort = limit.get("effort")
    if effort is None or not float(effort) > 0:
        todo = "state the largest torque [N m] or force [N] of its drive"
        place = f"{where}, limit effort"
        raise InputError(place, expected="a number above 0", got=effort or "none", todo=todo)


def _check_mimic(mimic: Element, kind: str, joints: dict[str, Element], where: str) -> None:
    name = mimic.get("joint", "")
    if name not in joints:
        todo = did_you_mean(name, joints)
        raise InputError(where, expected="a joint of this file", got=repr(name), todo=todo)
    led_by, multiplier = joints[name], number(mimic, "multiplier", 1.0)
    if led_by.get("type") == "fixed" or led_by.find("mimic") is not None:
        got = f"{name!r}, which is fixed or mimics another"
        raise InputError(where, expected="a joint that moves by itself", got=got)
    if number(mimic, "offset"):
        todo = "put the offset into the joint's origin"
        raise InputError(where, expected="no offset", got=f"offset {number(mimic, 'offset'):g}", todo=todo)
    slides = led_by.get("type") == "prismatic"
    if kind == "prismatic" and not slides:
        raise InputError(where, expected="a prismatic joint to follow", got=f"{name!r}, which turns")
    if kind != "prismatic" and (slides or not multiplier.is_integer()):
        got = f"{multiplier:g} times {name!r}{', which slides' * slides}"
        raise InputError(where, expected="a whole number times a joint that turns", got=got)
    if not multiplier:
        raise InputError(where, expected="a multiplier other than 0", got="0", todo="a joint that stands is fixed")
