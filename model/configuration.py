"""From a device, its free joints and a posture to the equations that are simulated and fitted.

One free joint: the equation of `model.joint` with the coefficients of the locked motion as parameters. Several:
M(q)·v̇ = Kp·τ − C·v − φ − spring − friction, solved for v̇ by Cramer's rule, with ids that end in the joint's number
(``sigma0_0``, ``Ks_1``).
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from model.algebra import velocity_symbol
from model.device import Device
from model.equations import Equations
from model.joint import joint_equations
from model.joint_parts import (
    INERTIAL,
    joint_friction,
    joint_inputs,
    joint_outputs,
    joint_quantities,
    joint_states,
    net_torque,
)
from model.locked import Coefficient, LockedDynamics, locked_motion
from model.quantity import Normal, Quantity

SPREAD = 5.0
"""Bounds of an inertial coefficient lie this many standard deviations of its prior from its first guess."""
RATIO = 20.0
"""A moment of inertia is known within this factor of its first guess."""


def configuration_equations(
    device: Device, free_joints: Sequence[int], posture: Sequence[float] | None = None
) -> Equations:
    """Return the equations of `free_joints` with all others locked at `posture` [rad] or [m] (default all 0).

    First guesses, bounds and priors are the device's: of the inertial coefficients those that its link guesses imply.
    """
    motion = locked_motion(device, free_joints, posture)
    if len(motion.joints) == 1 and {c.id for c in motion.coefficients} <= set(INERTIAL):
        return _single(device, motion)
    return coupled_equations(device, motion)


def _single(device: Device, motion: LockedDynamics) -> Equations:
    (j,) = motion.joints
    known = {c.id: c for c in motion.coefficients}
    first = tuple(inertial_quantity(known[id], structured=id) for id in INERTIAL if id in known)
    return joint_equations(j, parameters=(*first, *joint_quantities(device, j)), prismatic=device.joints[j].prismatic)


def inertial_quantity(c: Coefficient, *, structured: str = "") -> Quantity:
    """Return a coefficient as a parameter: a moment of inertia is positive, others lie within `SPREAD` of the guess."""
    positive = c.initial > 0 and (c.id == "inertia" or (c.id[0] == "M" and c.id[1:].endswith("_1") and _diagonal(c.id)))
    width = SPREAD * c.prior_std + 1e-12
    return Quantity(
        id=c.id,
        unit=c.unit,
        description=c.description,
        initial=c.initial,
        lower=c.initial / RATIO if positive else c.initial - width,
        upper=c.initial * RATIO if positive else c.initial + width,
        prior=Normal(mean=c.initial, std=c.prior_std) if c.prior_std > 0 else None,
        fixed=c.prior_std == 0,
        scale="log" if positive else "linear",
        structured=structured or f"coupling.{c.id}",
    )


def _diagonal(id: str) -> bool:
    """Whether ``M00_1`` names a diagonal entry."""
    digits = id[1:].partition("_")[0]
    half = len(digits) // 2
    return len(digits) % 2 == 0 and digits[:half] == digits[half:]


def coupled_equations(device: Device, motion: LockedDynamics) -> Equations:
    """Return the equations of several free joints, solved for the accelerations."""
    joints, M = motion.joints, sp.Matrix(motion.mass_matrix)
    load = [sp.expand(sp.expand(c) + g) for c, g in zip(motion.christoffel_force, motion.gravity_force, strict=True)]
    h = sp.Matrix([net_torque(j) - bias for j, bias in zip(joints, load, strict=True)])
    inverse_det, adjugate = 1 / M.det(method="berkowitz"), M.adjugate()
    acceleration = [(adjugate[i, :] * h)[0] * inverse_det for i in range(len(joints))]
    friction = [joint_friction(j) for j in joints]
    damping = [
        (sp.Symbol(f"sigma1_{j}", real=True) + sp.Symbol(f"sigma2_{j}", real=True)) * adjugate[i, i] * inverse_det
        for i, j in enumerate(joints)
    ]
    quantities = [inertial_quantity(c) for c in motion.coefficients]
    for j in joints:
        quantities += joint_quantities(device, j, suffix=f"_{j}", prefix=f"joint{j}.")
    return Equations(
        name=f"joints{''.join(map(str, joints))}",
        title=f"joints {', '.join(map(str, joints))}, all others locked",
        joints=joints,
        states=joint_states(device, joints),
        inputs=joint_inputs(device, joints),
        outputs=joint_outputs(device, joints),
        parameters=tuple(quantities),
        rhs=(*(velocity_symbol(j) for j in joints), *acceleration, *(f.bristle for f in friction)),
        rates=(*(sp.S.Zero for _ in joints), *damping, *(f.rate for f in friction)),
        orderings=tuple((f"Fs_{j}", f"Fc_{j}") for j in joints),
    )
