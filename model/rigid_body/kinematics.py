"""Where the links are and how they move, in body frames, over any scalar.

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
    """Joint positions over some scalar: floats and arrays, exact polynomials, tape nodes."""

    def constant(self, value: Fraction | int) -> Scalar:
        """Return a number of the geometry as a scalar."""
        ...

    def cos_sin(self, moved_by: Mapping[int, Fraction]) -> tuple[Scalar, Scalar]:
        """Return cosine and sine of Σ moved_by[j]·q_j."""
        ...

    def travel(self, moved_by: Mapping[int, Fraction]) -> Scalar:
        """Return Σ moved_by[j]·q_j."""
        ...

    def tidy(self, value: Scalar) -> Scalar:
        """Return `value` in canonical form."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Geometry:
    """A link's constant geometry, rational: rotation and origin at home, axis of motion."""

    home: Mat
    origin: Vec
    axis: Vec


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A link's frame in its parent's, and the axis of motion over the same scalar."""

    R: Mat
    p: Vec
    axis: Vec


@lru_cache(maxsize=1024)
def _geometry(origin: Vec, rpy: Vec, axis: Vec) -> Geometry:
    bare = Link(name="", origin=origin, rpy=rpy, axis=axis)
    x, y, z = (rational(value) for value in origin)
    return Geometry(home=home_rotation(bare), origin=(x, y, z), axis=unit_vector(axis))


def geometry(link: Link) -> Geometry:
    """Return the rational geometry of a link."""
    return _geometry(link.origin, link.rpy, link.axis)


def constant_vector(coordinates: Coordinates, vector: Vec) -> Vec:
    """Return a rational vector over the coordinates' scalar; whole 0 and ±1 stay ints."""
    x, y, z = (value if value in (0, 1, -1) else coordinates.constant(value) for value in vector)
    return x, y, z


def pose(link: Link, coordinates: Coordinates) -> Pose:
    """Return R and p of a link for the coordinates' positions."""
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
    """Return the pose of every link in its parent."""
    return {link.name: pose(link, coordinates) for link in device.links}


Column = tuple[Vec, Vec]
"""(w, v): angular velocity and velocity of the origin per unit of joint speed."""


def own_column(link: Link, placed: Pose, coordinates: Coordinates, joint: int) -> Column:
    """Return what joint `joint` adds at this very link."""
    ratio = link.moved_by.get(joint, Fraction(0))
    whole = int(ratio) if ratio.denominator == 1 else coordinates.constant(ratio)
    along = scale(whole, placed.axis)
    return (along, ZERO) if link.motion == "revolute" else (ZERO, along)


def body_jacobians(device: Device, coordinates: Coordinates, joints: tuple[int, ...]) -> dict[str, dict[int, Column]]:
    """Return the columns of every link's body Jacobian for `joints`; columns that are zero are left out.

    Recursion: w = Rᵀ w_parent, v = Rᵀ (v_parent + w_parent × p), plus the link's own motion.
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
    """Return every link's rotation and origin in the base frame."""
    result: dict[str, tuple[Mat, Vec]] = {BASE: (IDENTITY, ZERO)}
    for link in device.links:
        here = pose(link, coordinates)
        R, p = result[link.parent]
        first, second, third = (_tidy(row, coordinates) for row in product(R, here.R))
        result[link.name] = (first, second, third), _tidy(add(p, apply(R, here.p)), coordinates)
    return result
