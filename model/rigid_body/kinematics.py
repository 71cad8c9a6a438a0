"""Kinematics of the links in body frames, over any scalar: poses and body Jacobians.

`Device` and `Coordinates` come in, poses in the parent's or the base frame and columns of the body Jacobians go out.
Symbols: R turns link coordinates into the parent's, p is the link's origin in the parent's frame; column j of a link's
body Jacobian is (w_j, v_j), with ω = Σ w_j q̇_j and v = Σ v_j q̇_j, the velocity of its origin, in the link's frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

from haptid.model.algebra.rational_rotations import axis_rotation, home_rotation, rational, unit_vector
from haptid.model.algebra.vectors import IDENTITY, ZERO, Mat, Scalar, Vec, add, apply, cross, product, scale, transpose
from haptid.model.device.device import BASE, Device, Link


class Coordinates(Protocol):
    """Joint positions over some scalar: floats and arrays, exact polynomials, tape nodes.

    `Numbers`, `TrigRing` and `Tape` are the implementations.
    """

    def constant(self, value: Fraction | int) -> Scalar:
        """Return a number of the geometry as a scalar.

        Parameters
        ----------
        value
            Rational number.

        Returns
        -------
        Scalar
            The same number.
        """
        ...

    def cos_sin(self, moved_by: Mapping[int, Fraction]) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of Σ moved_by[j]·q_j.

        Parameters
        ----------
        moved_by
            Joint → coefficient.

        Returns
        -------
        cos, sin : Scalar
            Of the angle.
        """
        ...

    def travel(self, moved_by: Mapping[int, Fraction]) -> Scalar:
        """Return Σ moved_by[j]·q_j.

        Parameters
        ----------
        moved_by
            Joint → coefficient.

        Returns
        -------
        Scalar
            The sum [rad] or [m].
        """
        ...

    def tidy(self, value: Scalar) -> Scalar:
        """Return `value` in canonical form.

        Parameters
        ----------
        value
            Scalar.

        Returns
        -------
        Scalar
            An equal scalar.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """The constant geometry of a link, in rational numbers.

    Parameters
    ----------
    home
        Rotation from link to parent coordinates at home, shape (3, 3).
    origin
        Origin in the parent's frame at home [m], shape (3,).
    axis
        Unit vector of the motion in the link's frame, shape (3,).
    """

    home: Mat
    origin: Vec
    axis: Vec


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """The frame of a link in its parent's frame.

    Parameters
    ----------
    R
        Rotation from link to parent coordinates, shape (3, 3).
    p
        Origin in the parent's frame [m], shape (3,).
    axis
        Unit vector of the motion in the link's frame, shape (3,).
    """

    R: Mat
    p: Vec
    axis: Vec


@lru_cache(maxsize=1024)
def _geometry(origin: Vec, rpy: Vec, axis: Vec) -> Geometry:
    bare = Link(name="", origin=origin, rpy=rpy, axis=axis)
    x, y, z = (rational(value) for value in origin)
    return Geometry(home=home_rotation(bare), origin=(x, y, z), axis=unit_vector(axis))


def geometry(link: Link) -> Geometry:
    """Return the rational geometry of a link.

    Parameters
    ----------
    link
        Link of a device.

    Returns
    -------
    Geometry
        Rotation and origin at home, and axis of the motion.
    """
    return _geometry(link.origin, link.rpy, link.axis)


def constant_vector(coordinates: Coordinates, vector: Vec) -> Vec:
    """Convert a rational vector to the scalar of the coordinates; 0 and ±1 stay ints, which fold away.

    Parameters
    ----------
    coordinates
        Joint positions over the scalar.
    vector
        Rational vector, shape (3,).

    Returns
    -------
    Vec
        The same vector over the scalar, shape (3,).
    """
    x, y, z = (value if value in (0, 1, -1) else coordinates.constant(value) for value in vector)
    return x, y, z


def pose(link: Link, coordinates: Coordinates) -> Pose:
    """Compute the pose of a link in its parent's frame.

    Parameters
    ----------
    link
        Link with geometry and motion.
    coordinates
        Joint positions over a scalar.

    Returns
    -------
    Pose
        R, p and axis over the same scalar.
    """
    known = geometry(link)
    first, second, third = (constant_vector(coordinates, row) for row in known.home)
    home: Mat = (first, second, third)
    origin, axis = constant_vector(coordinates, known.origin), constant_vector(coordinates, known.axis)
    if link.motion == "revolute":
        return Pose(R=product(home, axis_rotation(axis, *coordinates.cos_sin(link.moved_by))), p=origin, axis=axis)
    if link.motion == "prismatic":
        origin = add(origin, apply(home, scale(coordinates.travel(link.moved_by), axis)))
    return Pose(R=home, p=origin, axis=axis)


def poses(device: Device, coordinates: Coordinates) -> dict[str, Pose]:
    """Return the pose of every link in its parent's frame, by the link's name.

    Parameters
    ----------
    device
        Device with its links.
    coordinates
        Joint positions over a scalar.

    Returns
    -------
    dict of str to Pose
        Pose by name of the link, in the order of the links.
    """
    return {link.name: pose(link, coordinates) for link in device.links}


Column = tuple[Vec, Vec]
"""(w, v): angular velocity and velocity of the origin per unit of joint speed."""


def own_column(link: Link, placed: Pose, coordinates: Coordinates, joint: int) -> Column:
    """Return the contribution of a link's own motion to one column of its body Jacobian.

    Parameters
    ----------
    link
        Link with its motion.
    placed
        Pose of the link, over the scalar of ``coordinates``.
    coordinates
        Joint positions over a scalar.
    joint
        Number of the joint of the column.

    Returns
    -------
    Column
        (w, v) of the link relative to its parent per unit of joint speed, in the link's frame.
    """
    ratio = link.moved_by.get(joint, Fraction(0))
    whole = int(ratio) if ratio.denominator == 1 else coordinates.constant(ratio)
    along = scale(whole, placed.axis)
    return (along, ZERO) if link.motion == "revolute" else (ZERO, along)


def body_jacobians(device: Device, coordinates: Coordinates, joints: tuple[int, ...]) -> dict[str, dict[int, Column]]:
    """Compute the body Jacobians of all links.

    Parameters
    ----------
    device
        Device with its links behind their parents.
    coordinates
        Joint positions over a scalar.
    joints
        Numbers of the joints that give the columns.

    Returns
    -------
    dict of str to dict of int to Column
        Link → joint → (w, v); columns of joints that do not move the link are left out.

    Notes
    -----
    Recursion from the base: w = Rᵀ w_parent, v = Rᵀ (v_parent + w_parent × p), plus the link's own motion.
    """
    placed = poses(device, coordinates)
    result: dict[str, dict[int, Column]] = {BASE: {}}
    for link in device.links:
        here, above = placed[link.name], result[link.parent]
        back = transpose(here.R)
        columns: dict[int, Column] = {}
        for j in joints:
            w, v = above.get(j, (ZERO, ZERO))
            own_w, own_v = own_column(link, here, coordinates, j) if j in link.moved_by else (ZERO, ZERO)
            if j in above or j in link.moved_by:
                turned = add(apply(back, w), own_w), add(apply(back, add(v, cross(w, here.p))), own_v)
                columns[j] = _tidy(turned[0], coordinates), _tidy(turned[1], coordinates)
        result[link.name] = columns
    return result


def _tidy(vector: Vec, coordinates: Coordinates) -> Vec:
    x, y, z = (coordinates.tidy(value) for value in vector)
    return x, y, z


def base_poses(device: Device, coordinates: Coordinates) -> dict[str, tuple[Mat, Vec]]:
    """Compute the poses of all links in the base frame.

    Parameters
    ----------
    device
        Device with its links behind their parents.
    coordinates
        Joint positions over a scalar.

    Returns
    -------
    dict of str to (Mat, Vec)
        Link → rotation from link to base coordinates, shape (3, 3), and origin [m], shape (3,).
    """
    result: dict[str, tuple[Mat, Vec]] = {BASE: (IDENTITY, ZERO)}
    for link in device.links:
        here = pose(link, coordinates)
        R, p = result[link.parent]
        first, second, third = (_tidy(row, coordinates) for row in product(R, here.R))
        result[link.name] = (first, second, third), _tidy(add(p, apply(R, here.p)), coordinates)
    return result
