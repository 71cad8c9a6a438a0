"""Checks of the joints of a URDF: type, axis, limits, friction, and the joint that a mimicking joint follows."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from haptid.model.device.stated_parameters import check_parameters
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

TYPES = ("revolute", "continuous", "prismatic", "fixed")
STICTION = 1.2
"""First guess of stiction over Coulomb friction; a URDF states a single number for both."""


def number(element: Element | None, key: str, default: float = 0.0) -> float:
    """Return an attribute that was checked to be a number, else the default that URDF gives it."""
    text = None if element is None else element.get(key)
    return default if text is None else float(text)


def friction_guesses(joint: Element) -> dict[str, dict[str, float]]:
    """Return first guesses of friction from ``<dynamics>``, where 0 says that nothing is known."""
    dynamics = joint.find("dynamics")
    damping, friction = number(dynamics, "damping"), number(dynamics, "friction")
    roles = law_named(DEFAULT).roles
    viscous = {roles.viscous: {"initial": damping}} if damping else {}
    dry = {roles.coulomb: {"initial": friction}, roles.stiction: {"initial": STICTION * friction}} if friction else {}
    return viscous | dry


def check_joint(joint: Element, joints: dict[str, Element], where: str) -> None:
    """Refuse one joint; ``joints`` are all of the file by name.

    Raises
    ------
    InputError
        Where a limit that URDF demands is missing or leaves no motion or no effort, where a number cannot be, or where
        the joint follows none that moves by itself.
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
        stiction = f"friction (stiction is {STICTION} times it)"
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
