"""Mass, first moment and inertia of a body over any scalar, and the coordinate of a link's motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from haptid.model.algebra.vectors import Mat, Scalar, Vec, plus, times
from haptid.model.device.device import Link
from haptid.model.rigid_body.kinematics import Coordinates

Inertials = Mapping[str, tuple[Scalar, ...]]
"""Link → (m, mx, my, mz, L11, L22, L33, L12, L13, L23) about its origin, over the scalar; massless links are absent."""
Rates = Mapping[int, Scalar]
"""Joint → speed or acceleration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """Inertial parameters of a link or of a composite body, about the origin of its frame.

    Parameters
    ----------
    m
        Mass [kg].
    h
        First moment m·c [kg m], shape (3,).
    L
        Inertia about the origin [kg m²], shape (3, 3).
    """

    m: Scalar
    h: Vec
    L: Mat


def body(values: tuple[Scalar, ...]) -> Body:
    """Return the body of ten barycentric parameters, in the order of `inertial_parameters.BARYCENTRIC`.

    Parameters
    ----------
    values
        m [kg], h [kg m] (three), L [kg m²] (six).

    Returns
    -------
    Body
        The same numbers as mass, vector and matrix.
    """
    m, x, y, z, L11, L22, L33, L12, L13, L23 = values
    return Body(m=m, h=(x, y, z), L=((L11, L12, L13), (L12, L22, L23), (L13, L23, L33)))


def coordinate(link: Link, rates: Rates, coordinates: Coordinates) -> Scalar:
    """Return the speed or acceleration of a link's own motion, Σ_j moved_by[j]·rates[j].

    Parameters
    ----------
    link
        Link with the joints that move it.
    rates
        Speeds or accelerations by joint; 0 for a joint that is absent.
    coordinates
        Joint positions over the scalar.

    Returns
    -------
    Scalar
        Speed [rad/s] or [m/s], or acceleration [rad/s²] or [m/s²].
    """
    return plus(*(times(ratio_of(ratio, coordinates), rates.get(j, 0)) for j, ratio in link.moved_by.items()))


def ratio_of(ratio: Fraction, coordinates: Coordinates) -> Scalar:
    """Return a ratio as a scalar; a whole number stays an int, which folds away where it is 0 or ±1.

    Parameters
    ----------
    ratio
        Coefficient of a joint in the motion of a link.
    coordinates
        Joint positions over the scalar.

    Returns
    -------
    Scalar
        The ratio, as an int or as `coordinates` convert it.
    """
    return int(ratio) if ratio.denominator == 1 else coordinates.constant(ratio)
