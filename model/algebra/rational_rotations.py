"""Rational geometry: rotations that are exactly orthogonal, so that ranks and cancellations are exact."""

from __future__ import annotations

import math
from fractions import Fraction

from haptid.model.algebra.vectors import IDENTITY, Mat, Scalar, Vec, add_matrices, plus, product, scale, times
from haptid.model.device.device import Link, Vector

LARGEST_DENOMINATOR = 10**8
"""Largest denominator of the rational parameter t = tan(angle/2); the error of t is about its inverse squared."""


def rational(x: float) -> Fraction | int:
    """Convert a float to the rational number of its shortest decimal text, so that 0.1 becomes 1/10.

    Parameters
    ----------
    x
        Finite number.

    Returns
    -------
    Fraction or int
        The decimal number exactly; an int where it is whole.
    """
    fraction = Fraction(repr(float(x)))
    return int(fraction) if fraction.denominator == 1 else fraction


def cos_sin(angle: float) -> tuple[Fraction | int, Fraction | int]:
    """Approximate cosine and sine of an angle by a rational point of the unit circle.

    Parameters
    ----------
    angle
        Angle [rad].

    Returns
    -------
    tuple of (Fraction or int)
        (c, s) with c² + s² = 1 exactly, within 1e-15 of cosine and sine of the angle.

    Notes
    -----
    Quarter turns are split off and exact. The remaining angle has t = tan(angle/2), rounded to a rational number, and
    c = (1 − t²)/(1 + t²), s = 2t/(1 + t²).
    """
    quarters = round(angle / (math.pi / 2))
    rest = angle - quarters * (math.pi / 2)
    t = Fraction(math.tan(rest / 2)).limit_denominator(LARGEST_DENOMINATOR) if abs(rest) > 1e-14 else Fraction(0)
    c, s = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    # a quarter turn as an exchange of cosine and sine keeps both exact
    for _ in range(quarters % 4):
        c, s = -s, c
    return _whole(c), _whole(s)


def rational_vector(vector: Vector) -> Vec:
    """Return the decimals of `vector` as rational numbers.

    Parameters
    ----------
    vector
        Three floating-point numbers.

    Returns
    -------
    Vec
        The three as `rational` converts them.
    """
    x, y, z = (rational(value) for value in vector)
    return x, y, z


def _whole(x: Fraction) -> Fraction | int:
    return int(x) if x.denominator == 1 else x


def unit_vector(axis: Vector) -> Vec:
    """Approximate a unit vector by a rational vector of exactly unit length.

    Parameters
    ----------
    axis
        Unit vector, shape (3,).

    Returns
    -------
    Vec
        Rational unit vector along `axis`.

    Notes
    -----
    Inverse stereographic projection: with rational coordinates (u, v) of the projected axis, the vector
    (±(1 − u² − v²), 2u, 2v)/(1 + u² + v²) has length 1 exactly.
    """
    # projected along the largest component, the denominator 1 + |component| is far from 0
    largest = max(range(3), key=lambda i: abs(axis[i]))
    sign = 1 if axis[largest] > 0 else -1
    others = [i for i in range(3) if i != largest]
    u, v = (Fraction(axis[i] / (1 + abs(axis[largest]))).limit_denominator(LARGEST_DENOMINATOR) for i in others)
    square = 1 + u * u + v * v
    result: list[Scalar] = [0, 0, 0]
    result[largest] = _whole(sign * (2 - square) / square)
    result[others[0]], result[others[1]] = _whole(2 * u / square), _whole(2 * v / square)
    return result[0], result[1], result[2]


def axis_rotation(axis: Vec, c: Scalar, s: Scalar) -> Mat:
    """Return the rotation about an axis by Rodrigues' formula, R = c·1 + s·[a]× + (1 − c)·a aᵀ.

    Parameters
    ----------
    axis
        Unit vector a; a coordinate axis needs no products.
    c, s
        Cosine and sine of the angle, over any scalar.

    Returns
    -------
    Mat
        Rotation matrix R, shape (3, 3).
    """
    x, y, z = axis
    if sum(1 for a in axis if a == 0) == 2:
        return _coordinate_rotation(axis, c, s)
    skew: Mat = ((0, -z, y), (z, 0, -x), (-y, x, 0))
    outer: Mat = (scale(x, axis), scale(y, axis), scale(z, axis))
    rest = plus(1, times(-1, c))
    parts = (
        tuple(scale(c, row) for row in IDENTITY),
        tuple(scale(s, row) for row in skew),
        tuple(scale(rest, row) for row in outer),
    )
    first, second, third = parts
    return add_matrices(add_matrices(first, second), third)  # type: ignore[arg-type]  # tuples of three rows


def _coordinate_rotation(axis: Vec, c: Scalar, s: Scalar) -> Mat:
    along = next(i for i in range(3) if axis[i] != 0)
    s = times(axis[along], s)
    minus_s = times(-1, s)
    if along == 0:
        return ((1, 0, 0), (0, c, minus_s), (0, s, c))
    if along == 1:
        return ((c, 0, s), (0, 1, 0), (minus_s, 0, c))
    return ((c, minus_s, 0), (s, c, 0), (0, 0, 1))


def home_rotation(link: Link) -> Mat:
    """Return the exactly orthogonal rotation of a link's frame at home.

    Parameters
    ----------
    link
        Link with fixed-axis roll, pitch, yaw [rad].

    Returns
    -------
    Mat
        R = Rz(yaw)·Ry(pitch)·Rx(roll) with rational entries, shape (3, 3), from link to parent coordinates.
    """
    roll, pitch, yaw = (cos_sin(angle) for angle in link.rpy)
    turned = product(_coordinate_rotation((0, 1, 0), *pitch), _coordinate_rotation((1, 0, 0), *roll))
    return product(_coordinate_rotation((0, 0, 1), *yaw), turned)
