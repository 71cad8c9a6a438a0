"""Orientation of a link as a unit quaternion (w, x, y, z), a polynomial in cosines and sines of half angles."""

from __future__ import annotations

from fractions import Fraction

from haptid.model.algebra.rational_rotations import cos_sin
from haptid.model.algebra.vectors import Scalar, Vec, add, cross, dot, plus, scale, times
from haptid.model.device.device import BASE, Device, Link
from haptid.model.rigid_body.kinematics import Coordinates, constant_vector, geometry

Quaternion = tuple[Scalar, Vec]
"""Scalar part and vector part."""


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the Hamilton product a·b, the rotation b followed by a.

    Parameters
    ----------
    a, b
        Quaternions: scalar part and vector part.

    Returns
    -------
    Quaternion
        Of norm 1 where both factors have it.
    """
    (w, u), (x, v) = a, b
    return plus(times(w, x), -dot(u, v)), add(scale(w, v), scale(x, u), cross(u, v))


def orientation(device: Device, coordinates: Coordinates, name: str) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Compute the orientation of a link in the base frame.

    Parameters
    ----------
    device
        Device with the link.
    coordinates
        Joint positions over a scalar.
    name
        Name of the link.

    Returns
    -------
    tuple of Scalar
        Unit quaternion (w, x, y, z) of the rotation from link to base coordinates.
    """
    result: Quaternion = (1, (0, 0, 0))
    while name != BASE:
        link = device.link(name)
        result = multiply(_of_link(link, coordinates), result)
        name = link.parent
    w, (x, y, z) = result
    return w, x, y, z


def _of_link(link: Link, coordinates: Coordinates) -> Quaternion:
    home: Quaternion = (1, (0, 0, 0))
    for angle, axis in zip(link.rpy, ((1, 0, 0), (0, 1, 0), (0, 0, 1)), strict=True):
        c, s = cos_sin(angle / 2)
        home = multiply((_number(c, coordinates), scale(_number(s, coordinates), axis)), home)
    if link.motion != "revolute":
        return home
    half = {j: ratio * Fraction(1, 2) for j, ratio in link.moved_by.items()}
    c, s = coordinates.cos_sin(half)
    return multiply(home, (c, scale(s, constant_vector(coordinates, geometry(link).axis))))


def _number(value: Fraction | int, coordinates: Coordinates) -> Scalar:
    return value if isinstance(value, int) else coordinates.constant(value)
