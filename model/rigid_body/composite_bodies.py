"""The mass matrix by composite rigid bodies (Featherstone 2008, section 6.2), over the tree and over any scalar.

`Device` and inertial parameters come in, M goes out. For each link, from the tips to the base:

1. The link and everything beyond it form one composite body, which is added to the parent's composite.
2. A unit acceleration of the link's coordinate needs a wrench on this composite body.
3. The wrench, carried down to the base and projected on each ancestor's axis, gives one row of the mass matrix.

Links that share a joint are treated as if each had its own coordinate, then projected by `moved_by`.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haptid.model.algebra.vectors import (
    Mat,
    Scalar,
    Vec,
    add,
    add_matrices,
    apply,
    cross,
    dot,
    minus,
    plus,
    scale,
    times,
    turn,
)
from haptid.model.device.device import BASE, Device, Link
from haptid.model.rigid_body.body import Body, Inertials, body, ratio_of
from haptid.model.rigid_body.kinematics import Coordinates, Pose, poses


def mass_matrix(
    device: Device, coordinates: Coordinates, inertials: Inertials, motors: tuple[Scalar, ...] = ()
) -> tuple[tuple[Scalar, ...], ...]:
    """Compute the mass matrix by composite rigid bodies.

    Parameters
    ----------
    device
        Device with n_q joints.
    coordinates
        Joint positions over a scalar.
    inertials
        Barycentric parameters by link, over the same scalar.
    motors
        Rotor inertias [kg m²] in the order of ``device.motors``; no rotors where empty.

    Returns
    -------
    tuple of tuple of Scalar
        M, shape (n_q, n_q), in kg m² for a pair of revolute joints.
    """
    placed = poses(device, coordinates)
    composite: dict[str, Body] = {name: body(values) for name, values in inertials.items()}
    n = len(device.joints)
    M: list[list[Scalar]] = [[0] * n for _ in range(n)]
    above = {link.name: link for link in device.links}
    # links stand behind their parents: in reverse order every composite is complete before it is used
    for link in reversed(device.links):
        if link.name not in composite:
            continue
        own = composite[link.name]
        if link.parent != BASE:
            moved = _move_body(own, placed[link.name], coordinates)
            composite[link.parent] = _join_bodies(composite[link.parent], moved) if link.parent in composite else moved
        if link.moved_by:
            _fill(M, _along_the_path(link, own, placed, above), link, coordinates)
    for motor, J in zip(device.motors, motors, strict=False):
        for i, a in motor.ratios.items():
            for j, b in motor.ratios.items():
                M[i][j] = plus(M[i][j], times(ratio_of(a * b, coordinates), J))
    return tuple(tuple(row) for row in M)


def _along_the_path(
    link: Link, own: Body, placed: Mapping[str, Pose], above: Mapping[str, Link]
) -> list[tuple[Link, Scalar]]:
    """Return the generalised force of a unit acceleration of the link's coordinate, for it and each ancestor."""
    axis = placed[link.name].axis
    F, N = (
        (cross(axis, own.h), apply(own.L, axis))
        if link.motion == "revolute"
        else (scale(own.m, axis), cross(own.h, axis))
    )
    result = []
    here = link
    while True:
        frame = placed[here.name]
        if here.moved_by:
            result.append((here, dot(frame.axis, N if here.motion == "revolute" else F)))
        if here.parent == BASE:
            return result
        F = apply(frame.R, F)
        N = add(apply(frame.R, N), cross(frame.p, F))
        here = above[here.parent]


def _fill(M: list[list[Scalar]], path: list[tuple[Link, Scalar]], link: Link, coordinates: Coordinates) -> None:
    for other, value in path:
        for i, a in link.moved_by.items():
            for j, b in other.moved_by.items():
                term = times(ratio_of(a * b, coordinates), value)
                M[i][j] = plus(M[i][j], term)
                if other is not link:
                    M[j][i] = plus(M[j][i], term)


def _move_body(inertial: Body, frame: Pose, coordinates: Coordinates) -> Body:
    """Return the body seen from the parent: h' = R·h + m·p, L' = R·L·Rᵀ + terms of p (Steiner)."""
    p, m = frame.p, inertial.m
    turned = apply(frame.R, inertial.h)
    shift = scale(m, p)
    # b = R·h + m·p/2: the terms of h and those of m·p·pᵀ come from one product 2(p·b)·1 − p bᵀ − b pᵀ
    half = add(turned, scale(coordinates.constant(Fraction(1, 2)), shift))
    return Body(m=m, h=add(turned, shift), L=add_matrices(turn(frame.R, inertial.L), _steiner(p, half)))


def _steiner(p: Vec, b: Vec) -> Mat:
    """2(p·b)·1 − p bᵀ − b pᵀ."""
    twice = [times(2, times(x, y)) for x, y in zip(p, b, strict=True)]
    off = {(i, j): minus(plus(times(p[i], b[j]), times(p[j], b[i]))) for i, j in ((0, 1), (0, 2), (1, 2))}
    return (
        (plus(twice[1], twice[2]), off[0, 1], off[0, 2]),
        (off[0, 1], plus(twice[0], twice[2]), off[1, 2]),
        (off[0, 2], off[1, 2], plus(twice[0], twice[1])),
    )


def _join_bodies(first: Body, second: Body) -> Body:
    return Body(m=plus(first.m, second.m), h=add(first.h, second.h), L=add_matrices(first.L, second.L))
