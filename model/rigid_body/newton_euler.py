"""Newton-Euler: the torques of a motion, recursively over the tree and over any scalar.

Body frames throughout (Featherstone 2008, section 5.3, written with origins instead of centroids): with
U = [α]ₓ + [ω]ₓ[ω]ₓ a link feels the force F = m·a + U·h and the moment N = L·α + ω × (L·ω) + h × a about its origin.
Links that share a joint (passive ones) are treated as if each had its own coordinate, then projected by `moved_by`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from haptid.model.algebra.rational_rotations import rational_vector
from haptid.model.algebra.vectors import (
    ZERO,
    Mat,
    Scalar,
    Vec,
    add,
    apply,
    cross,
    dot,
    minus,
    plus,
    scale,
    times,
    transpose,
)
from haptid.model.device.device import BASE, Device
from haptid.model.rigid_body.body import Body, Inertials, Rates, body, coordinate, ratio_of
from haptid.model.rigid_body.kinematics import Coordinates, Pose, constant_vector, poses


@dataclass(frozen=True, slots=True, kw_only=True)
class _Motion:
    w: Vec
    alpha: Vec
    a: Vec
    U: Mat


def inverse_dynamics(
    device: Device, coordinates: Coordinates, inertials: Inertials, speeds: Rates, accelerations: Rates
) -> tuple[Scalar, ...]:
    """Compute the joint torques of a motion by recursive Newton-Euler.

    Parameters
    ----------
    device
        Device with n_q joints.
    coordinates
        Joint positions over a scalar.
    inertials
        Barycentric parameters by link, over the same scalar; links without an entry have no mass.
    speeds, accelerations
        Joint → q̇ and q̈; joints without an entry have 0.

    Returns
    -------
    tuple of Scalar
        M·q̈ + C·q̇ + φ of the links [N m] or [N], shape (n_q,); rotor inertias are not included.
    """
    placed = poses(device, coordinates)
    motions = _forward(device, coordinates, placed, speeds, accelerations)
    wrenches: dict[str, tuple[Vec, Vec]] = {}
    for link in device.links:
        wrenches[link.name] = (
            _wrench(body(inertials[link.name]), motions[link.name]) if link.name in inertials else (ZERO, ZERO)
        )
    torques: list[Scalar] = [0] * len(device.joints)
    # links stand behind their parents: in reverse order a wrench is complete before it is projected and passed on
    for link in reversed(device.links):
        here, (F, N) = placed[link.name], wrenches[link.name]
        along = dot(here.axis, N if link.motion == "revolute" else F)
        for j, ratio in link.moved_by.items():
            torques[j] = plus(torques[j], times(ratio_of(ratio, coordinates), along))
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
    # gravity as an acceleration −g of the base adds φ to the torques of every link
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
