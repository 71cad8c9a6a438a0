"""Check of the inertia and gravity that a joint's links imply.

Mass and length may each lie within their ranges and still imply an inertia that no joint has.
"""

from __future__ import annotations

from haptid.model.device.device import Device
from haptid.model.device.stated_parameters import ROWS, possible_range
from haptid.model.rigid_body.locked_dynamics import Coefficient, LockedDynamics
from haptid.support.errors import InputError


def checked_coefficients(device: Device, motion: LockedDynamics) -> tuple[Coefficient, ...]:
    """Return the coefficients of a single free joint after a check of their size.

    Parameters
    ----------
    device
        Device, which the messages name.
    motion
        Equation of motion of exactly one free joint.

    Returns
    -------
    tuple of Coefficient
        The coefficients of ``motion``.

    Raises
    ------
    InputError
        Where the joint has no inertia, or the first guesses imply an inertia or gravity torque outside its possible
        range.
    """
    (joint,) = motion.joints
    where = f"device {device.name}, joint {joint} ({device.joints[joint].name})"
    if not any(c.id.startswith("inertia") and c.initial for c in motion.coefficients):
        todo = "the links that it moves are points on its axis: state centroid or inertia"
        raise InputError(where, expected="a joint with inertia", got="0 kg m^2", todo=todo)
    for coefficient in motion.coefficients:
        if coefficient.id in ROWS:
            _check_size(coefficient, where)
    return motion.coefficients


def _check_size(coefficient: Coefficient, where: str) -> None:
    least, most = possible_range(coefficient.id)
    if not least <= coefficient.initial <= most:
        expected = f"{coefficient.id} from {least:g} to {most:g} {coefficient.unit} from its links and motors"
        todo = "check masses, lengths, ratios and their units"
        raise InputError(where, expected=expected, got=f"{coefficient.initial:g}", todo=todo)
