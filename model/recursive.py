"""Recursive dynamics of the tree over any scalar: Newton-Euler torques and the composite-rigid-body mass matrix.

Body frames throughout (Featherstone 2008, sections 5.3 and 6.2, written with origins instead of centroids): with
U = [α]ₓ + [ω]ₓ[ω]ₓ a link feels the force F = m·a + U·h and the moment N = L·α + ω × (L·ω) + h × a about its origin.
Links that share a joint (passive ones) are first treated as if each had its own coordinate, then projected by
`moved_by`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from model.device import BASE, Device, Link
from model.exact import rational_vector
from model.kinematics import Coordinates, Pose, constant_vector, poses
from model.spatial import (
    ZERO,
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
    transpose,
    turn,
)

Inertials = Mapping[str, tuple[Scalar, ...]]
"""Link → (m, mx, my, mz, L11, L22, L33, L12, L13, L23) about its origin, over the scalar; massless links are absent."""
Rates = Mapping[int, Scalar]
"""Joint → speed or acceleration."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """m, h and L of a link or of a composite."""

    m: Scalar
    h: Vec
    L: Mat


@dataclass(frozen=True, slots=True, kw_only=True)
class _Motion:
    w: Vec
    alpha: Vec
    a: Vec
    U: Mat


def body(values: tuple[Scalar, ...]) -> Body:
    """Return the body of ten barycentric parameters."""
    m, x, y, z, L11, L22, L33, L12, L13, L23 = values
    return Body(m=m, h=(x, y, z), L=((L11, L12, L13), (L12, L22, L23), (L13, L23, L33)))


def coordinate(link: Link, rates: Rates, coordinates: Coordinates) -> Scalar:
    """Return Σ moved_by[j]·rates[j]."""
    return plus(*(times(_ratio(ratio, coordinates), rates.get(j, 0)) for j, ratio in link.moved_by.items()))


def _ratio(ratio: Fraction, coordinates: Coordinates) -> Scalar:
    return int(ratio) if ratio.denominator == 1 else coordinates.constant(ratio)


def inverse_dynamics(
    device: Device, coordinates: Coordinates, inertials: Inertials, speeds: Rates, accelerations: Rates
) -> tuple[Scalar, ...]:
    """Return M·q̈ + C·q̇ + φ of the links (rotors left out), shape (n_q,), by Newton-Euler."""
    placed = poses(device, coordinates)
    motions = _forward(device, coordinates, placed, speeds, accelerations)
    wrenches: dict[str, tuple[Vec, Vec]] = {}
    for link in device.links:
        wrenches[link.name] = (
            _wrench(body(inertials[link.name]), motions[link.name]) if link.name in inertials else (ZERO, ZERO)
        )
    torques: list[Scalar] = [0] * len(device.joints)
    for link in reversed(device.links):
        here, (F, N) = placed[link.name], wrenches[link.name]
        along = dot(here.axis, N if link.motion == "revolute" else F)
        for j, ratio in link.moved_by.items():
            torques[j] = plus(torques[j], times(_ratio(ratio, coordinates), along))
        if link.parent != BASE:
            above_F, above_N = wrenches[link.parent]
            turned = apply(here.R, F)
            wrenches[link.parent] = add(above_F, turned), add(above_N, apply(here.R, N), cross(here.p, turned))
    return tuple(torques)


def _forward(
    device: Device, coordinates: Coordinates, placed: Mapping[str, Pose], speeds: Rates, accelerations: Rates
) -> dict[str, _Motion]:
    g = constant_vector(coordinates, rational_vector(device.gravity))
    nothing: Mat = (ZERO, ZERO, ZERO)
    motions = {BASE: _Motion(w=ZERO, alpha=ZERO, a=scale(-1, g), U=nothing)}
    for link in device.links:
        here, above = placed[link.name], motions[link.parent]
        back = transpose(here.R)
        rate, push = coordinate(link, speeds, coordinates), coordinate(link, accelerations, coordinates)
        w, alpha = apply(back, above.w), apply(back, above.alpha)
        a = apply(back, add(above.a, apply(above.U, here.p)))
        along = scale(rate, here.axis)
        if link.motion == "prismatic":
            a = add(a, scale(2, cross(w, along)), scale(push, here.axis))
        elif link.motion == "revolute":
            alpha = add(alpha, cross(w, along), scale(push, here.axis))
            w = add(w, along)
        motions[link.name] = _Motion(w=w, alpha=alpha, a=a, U=_rotational(w, alpha))
    return motions


def _rotational(w: Vec, alpha: Vec) -> Mat:
    """U = [α]ₓ + [ω]ₓ[ω]ₓ."""
    xx, yy, zz = (times(component, component) for component in w)
    xy, xz, yz = times(w[0], w[1]), times(w[0], w[2]), times(w[1], w[2])
    return (
        (minus(plus(yy, zz)), plus(xy, minus(alpha[2])), plus(xz, alpha[1])),
        (plus(xy, alpha[2]), minus(plus(xx, zz)), plus(yz, minus(alpha[0]))),
        (plus(xz, minus(alpha[1])), plus(yz, alpha[0]), minus(plus(xx, yy))),
    )


def _wrench(inertial: Body, motion: _Motion) -> tuple[Vec, Vec]:
    F = add(scale(inertial.m, motion.a), apply(motion.U, inertial.h))
    spin = cross(motion.w, apply(inertial.L, motion.w))
    return F, add(apply(inertial.L, motion.alpha), spin, cross(inertial.h, motion.a))


def mass_matrix(
    device: Device, coordinates: Coordinates, inertials: Inertials, motors: tuple[Scalar, ...] = ()
) -> tuple[tuple[Scalar, ...], ...]:
    """Return M, shape (n_q, n_q), by composite rigid bodies; `motors` holds the rotor inertias in order."""
    placed = poses(device, coordinates)
    composite: dict[str, Body] = {name: body(values) for name, values in inertials.items()}
    n = len(device.joints)
    M: list[list[Scalar]] = [[0] * n for _ in range(n)]
    above = {link.name: link for link in device.links}
    for link in reversed(device.links):
        if link.name not in composite:
            continue
        own = composite[link.name]
        if link.parent != BASE:
            moved = _moved(own, placed[link.name], coordinates)
            composite[link.parent] = _joined(composite[link.parent], moved) if link.parent in composite else moved
        if link.moved_by:
            _fill(M, _along_the_path(link, own, placed, above), link, coordinates)
    for motor, J in zip(device.motors, motors, strict=False):
        for i, a in motor.ratios.items():
            for j, b in motor.ratios.items():
                M[i][j] = plus(M[i][j], times(_ratio(a * b, coordinates), J))
    return tuple(tuple(row) for row in M)


def _along_the_path(
    link: Link, own: Body, placed: Mapping[str, Pose], above: Mapping[str, Link]
) -> list[tuple[Link, Scalar]]:
    """Return what a unit acceleration of the link's coordinate asks of its own and of each ancestor's coordinate."""
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
                term = times(_ratio(a * b, coordinates), value)
                M[i][j] = plus(M[i][j], term)
                if other is not link:
                    M[j][i] = plus(M[j][i], term)


def _moved(inertial: Body, frame: Pose, coordinates: Coordinates) -> Body:
    """Return the body seen from the parent: h' = R·h + m·p, L' = R·L·Rᵀ + terms of p (Steiner)."""
    p, m = frame.p, inertial.m
    turned = apply(frame.R, inertial.h)
    shift = scale(m, p)
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


def _joined(first: Body, second: Body) -> Body:
    return Body(m=plus(first.m, second.m), h=add(first.h, second.h), L=add_matrices(first.L, second.L))
