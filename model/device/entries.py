"""Convert the entries of a device file to parts of a `Device`: joints, links and motors.

Tables that a JSON Schema has accepted come in; the checks here are those that a schema cannot express.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from haptid.model.device import ranges
from haptid.model.device.device import BASE, Guess, Joint, Link, Motor, Vector
from haptid.model.device.link_guesses import Uncertainty, inertial
from haptid.model.device.ranges import Range
from haptid.model.device.stated_parameters import check_parameters
from haptid.model.friction.law import FrictionLaw
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.support.errors import InputError
from haptid.support.files.place import Place
from haptid.support.suggestion import did_you_mean

Table = Mapping[str, Any]
OWN = ("Kp", "Ks", "epos")
"""Parameters of drive and spring that a joint may state; those of friction are its law's."""
Raw = float | Mapping[str, float]


def guess_of(value: Raw, place: Place) -> Guess:
    """Convert one stated value to a guess.

    Parameters
    ----------
    value
        Number, ``{ initial, lower, upper, std }`` or ``{ fixed }``.
    place
        Place of the value, for messages.

    Returns
    -------
    Guess
        The guess.

    Raises
    ------
    InputError
        Where the first guess lies outside the bounds or ``std`` is not positive.
    """
    try:
        if not isinstance(value, Mapping):
            return Guess(initial=float(value))
        if "fixed" in value:
            return Guess(initial=float(value["fixed"]), fixed=True)
        return _full_guess(**value)
    except ValueError as error:
        raise InputError(str(place), expected="lower <= initial <= upper, std > 0", got=str(error)) from None


def _full_guess(
    *, initial: float, lower: float = -math.inf, upper: float = math.inf, std: float | None = None
) -> Guess:
    return Guess(initial=float(initial), lower=float(lower), upper=float(upper), std=std)


def uncertainty_of(table: Table, place: Place) -> Uncertainty:
    """Convert the ``[uncertainty]`` table to standard deviations of plain numbers.

    Parameters
    ----------
    table
        Table by the fields of `Uncertainty`; may be empty.
    place
        Place of the table, for messages.

    Returns
    -------
    Uncertainty
        Standard deviations, with defaults where nothing is stated.

    Raises
    ------
    InputError
        Where a number lies outside its range.
    """
    for key, value in table.items():
        (ranges.CENTROID_STD if key == "centroid" else ranges.RELATIVE).check(value, place.at(key))
    return Uncertainty(**table)


def joint_of(entry: Table, place: Place) -> Joint:
    """Convert one ``[[joints]]`` entry.

    Parameters
    ----------
    entry
        Table of the joint.
    place
        Place of the entry, for messages.

    Returns
    -------
    Joint
        The joint.

    Raises
    ------
    InputError
        Where limits are out of order or range, the friction law is unknown, or a parameter is wrong.
    """
    lower, upper = entry.get("position_limits", (-math.pi, math.pi))
    if not lower < upper:
        where = str(place.at("position_limits"))
        raise InputError(where, expected="lower < upper", got=f"[{lower}, {upper}]")
    for i, limit in enumerate((lower, upper)):
        ranges.POSITION.check(limit, place.at("position_limits", i))
    law = law_named(entry.get("friction", DEFAULT), str(place.at("friction")))
    return Joint(
        name=entry["name"],
        transmission=entry.get("transmission", "direct"),
        prismatic=entry.get("prismatic", False),
        friction=law.id,
        parameters=_parameters(entry.get("parameters", {}), law, place.at("parameters")),
        position_limits=(float(lower), float(upper)),
        torque_limit=ranges.TORQUE.check(entry.get("torque_limit", math.inf), place.at("torque_limit")),
        max_frequency=ranges.FREQUENCY.check(entry.get("max_frequency", math.inf), place.at("max_frequency")),
    )


def _parameters(table: Table, law: FrictionLaw, place: Place) -> dict[str, Guess]:
    known = (*OWN, *law.ids)
    for key in table:
        if key not in known:
            expected, todo = f"a parameter of a joint with {law.id} friction", did_you_mean(key, known)
            raise InputError(str(place.at(key)), expected=expected, got=repr(key), todo=todo)
    stated = {key: value if isinstance(value, Mapping) else {"initial": value} for key, value in table.items()}
    check_parameters(stated, lambda key: str(place.at(key)))
    return {key: guess_of(value, place.at(key)) for key, value in stated.items()}


def link_of(
    entry: Table, place: Place, above: Sequence[str], joints: Sequence[Joint], uncertainty: Uncertainty
) -> Link:
    """Convert one ``[[links]]`` entry.

    Parameters
    ----------
    entry
        Table of the link.
    place
        Place of the entry, for messages.
    above
        Names of the links before it in the file.
    joints
        All joints of the device.
    uncertainty
        Standard deviations of plain numbers.

    Returns
    -------
    Link
        The link.

    Raises
    ------
    InputError
        Where the name is taken, the parent does not stand above, or motion, geometry or inertia are impossible.
    """
    if entry["name"] in (*above, BASE):
        raise InputError(str(place.at("name")), expected="a name of its own", got=repr(entry["name"]))
    parent = entry.get("parent", BASE)
    if parent not in (*above, BASE):
        expected = f"base or a link above ({', '.join(above)})"
        raise InputError(str(place.at("parent")), expected=expected, got=repr(parent))
    motion = entry.get("motion", "revolute")
    most = ranges.TRAVEL if motion == "prismatic" else ranges.TURNS
    moved_by = _ratios(entry.get("moved_by", {}), place.at("moved_by"), len(joints), most)
    _check_motion(motion, moved_by, joints, place.at("moved_by"))
    return Link(
        name=entry["name"],
        title=entry.get("title", ""),
        parent=parent,
        motion=motion,
        origin=vector_of(entry.get("origin", (0, 0, 0)), ranges.LENGTH, place.at("origin")),
        rpy=vector_of(entry.get("rpy", (0, 0, 0)), ranges.ANGLE, place.at("rpy")),
        axis=_axis(entry.get("axis", (0, 0, 1)), place.at("axis")),
        moved_by=moved_by,
        inertial=inertial(entry, place, uncertainty, guess_of),
    )


def motor_of(entry: Table, place: Place, n_joints: int, uncertainty: Uncertainty) -> Motor:
    """Convert one ``[[motors]]`` entry.

    Parameters
    ----------
    entry
        Table of the motor.
    place
        Place of the entry, for messages.
    n_joints
        Number of joints of the device.
    uncertainty
        Standard deviations of plain numbers.

    Returns
    -------
    Motor
        The motor.

    Raises
    ------
    InputError
        Where inertia or ratio lie outside their ranges, or a joint does not exist.
    """
    at = place.at("inertia")
    guess = ranges.ROTOR.check_guess(guess_of(entry["inertia"], at), at, "leave a motor without inertia out")
    ratios = _ratios(entry["ratios"], place.at("ratios"), n_joints, ranges.GEAR)
    return Motor(name=entry["name"], inertia=uncertainty.rotor_guess(guess), ratios=ratios)


def _ratios(table: Table, place: Place, n_joints: int, most: Range) -> dict[int, Fraction]:
    ratios = {}
    for key, value in table.items():
        joint = int(key)  # the schema allows four digits
        if joint >= n_joints:
            raise InputError(str(place.at(key)), expected=f"a joint number 0..{n_joints - 1}", got=key)
        most.check(value, place.at(key), "")
        # by the decimal text: 0.1 becomes 1/10 instead of the binary fraction nearest to it
        ratios[joint] = Fraction(str(value))
    return ratios


def _check_motion(motion: str, moved_by: Mapping[int, Fraction], joints: Sequence[Joint], place: Place) -> None:
    if (motion == "fixed") != (not moved_by):
        got = ", ".join(f"joint {joint}" for joint in moved_by) or "none"
        raise InputError(str(place), expected="joints for a moving link, none for a fixed one", got=got)
    for joint, ratio in moved_by.items():
        where = str(place.at(str(joint)))
        if motion == "revolute" and (ratio.denominator != 1 or joints[joint].prismatic):
            got = f"{float(ratio):g}" + " times a prismatic one" * joints[joint].prismatic
            raise InputError(where, expected="a whole number times a revolute joint", got=got)
        if motion == "prismatic" and not joints[joint].prismatic:
            raise InputError(where, expected="a joint with prismatic = true", got=f"joint {joint}")


def check_moved(joints: Sequence[Joint], links: Sequence[Link], motors: Sequence[Motor], place: Place) -> None:
    """Check that every joint moves a link and a mass; without mass its equation would divide by zero.

    Parameters
    ----------
    joints, links, motors
        Parts of the device; links stand behind their parents.
    place
        Place of the device, for messages.

    Raises
    ------
    InputError
        At the first joint that moves no link, or neither a massive link nor a rotor.
    """
    for j in range(len(joints)):
        moved = {link.name for link in links if link.moved_by.get(j)}
        if not moved:
            raise InputError(str(place.at("joints", j)), expected="a link with this joint in moved_by", got="none")
        for link in links:  # children stand behind their parents
            moved |= {link.name} if link.parent in moved else set()
        heavy = any(link.inertial is not None and link.name in moved for link in links)
        if not heavy and not any(motor.ratios.get(j) for motor in motors):
            todo = "give a link that it moves mass, centroid and inertia"
            raise InputError(str(place.at("joints", j)), expected="a joint that moves a mass", got="none", todo=todo)


def vector_of(values: Sequence[float], each: Range, place: Place) -> Vector:
    """Return three numbers after a check of their range.

    Parameters
    ----------
    values
        Three numbers, in the unit of the range.
    each
        Range of each number.
    place
        Place of the three numbers, for messages.

    Returns
    -------
    Vector
        The three numbers.

    Raises
    ------
    InputError
        Where a number lies outside the range.
    """
    x, y, z = (each.check(value, place.at(i)) for i, value in enumerate(values))
    return x, y, z


def _axis(values: Sequence[float], place: Place) -> Vector:
    x, y, z = vector_of(values, ranges.DIRECTION, place)
    length = math.hypot(x, y, z)
    if not length > 1e-9:
        raise InputError(str(place), expected="a direction", got=f"[{x}, {y}, {z}]")
    return x / length, y / length, z / length
