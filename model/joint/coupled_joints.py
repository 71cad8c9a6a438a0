"""The equations that are simulated and fitted, from a device, its free joints and a lock posture.

`Device` comes in, `Equations` goes out. One free joint has the equation of `locked_joint` with the coefficients of the
locked motion as parameters. Several free joints have M(q)·v̇ = Kp·τ − C·v − φ − spring − friction, solved for v̇ by
Cramer's rule, with ids that end in the joint's number (``sigma0_0``, ``Ks_1``).
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from haptid.model.device.device import Device
from haptid.model.equations.drive import Drive
from haptid.model.equations.equations import Equations
from haptid.model.equations.fmu_names import COUPLING
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.joint.checked_coefficients import checked_coefficients
from haptid.model.joint.drive_terms import drive_quantities
from haptid.model.joint.joint_in_device import (
    INERTIAL,
    Effects,
    joint_inputs,
    joint_outputs,
    joint_part,
    joint_quantities,
    joint_rates,
    joint_rows,
    joint_states,
    names_of,
)
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.rigid_body.locked_dynamics import Coefficient, LockedDynamics, locked_motion
from haptid.model.thresholds import THRESHOLDS


def configuration_equations(
    device: Device,
    free_joints: Sequence[int],
    posture: Sequence[float] | None = None,
    effects: Effects | None = None,
    drive: Drive | None = None,
) -> Equations:
    """Build the equations of the free joints with all others locked.

    First guesses, bounds and priors are the device's: of the inertial coefficients those that its link guesses imply.

    Parameters
    ----------
    device
        Device with n_q joints.
    free_joints
        Numbers of the free joints.
    posture
        Positions of the locked joints [rad] or [m], shape (n_q,); entries of free joints are ignored. All 0 where None.
    effects
        Effects by joint; added where several joints are free (`model.joint.joint_in_device.joint_part`).
    drive
        What drives a single free joint; several take torques.

    Returns
    -------
    Equations
        Explicit equations with the position readings as outputs.

    Raises
    ------
    InputError
        Where a single free joint has an impossible inertia (`checked_coefficients`).
    """
    motion = locked_motion(device, free_joints, posture)
    if len(motion.joints) == 1 and {c.id for c in motion.coefficients} <= set(INERTIAL):
        return _single(device, motion, drive)
    # a single joint with other coefficients, as an inertia that varies with q, needs the general form
    return coupled_equations(device, motion, effects or {})


def _single(device: Device, motion: LockedDynamics, drive: Drive | None) -> Equations:
    (j,) = motion.joints
    known = {c.id: c for c in checked_coefficients(device, motion)}
    first = tuple(inertial_quantity(known[id], structured=id) for id in INERTIAL if id in known)
    joint = device.joints[j]
    driven = () if drive is None else drive_quantities(drive, prismatic=joint.prismatic)
    table = (*first, *joint_quantities(device, j), *driven)
    return joint_equations(j, parameters=table, prismatic=joint.prismatic, friction=joint.friction, drive=drive)


def inertial_quantity(c: Coefficient, *, structured: str = "") -> Quantity:
    """Return an inertial coefficient as a parameter with bounds and prior.

    Parameters
    ----------
    c
        Coefficient of a locked motion.
    structured
        Structured name; ``coupling.<id>`` where empty.

    Returns
    -------
    Quantity
        A moment of inertia (the constant part of a diagonal entry of M) is positive, on a logarithmic scale, within a
        factor `THRESHOLDS.largest_inertia_over_guess` of its first guess; any other coefficient lies
        within `THRESHOLDS.inertial_bounds_in_prior_std` prior standard deviations. A coefficient without uncertainty
        is fixed.
    """
    positive = c.initial > 0 and (c.id == "inertia" or (c.id[0] == "M" and c.id[1:].endswith("_1") and _diagonal(c.id)))
    # The last term keeps lower < upper where the prior has no width.
    width = THRESHOLDS.inertial_bounds_in_prior_std * c.prior_std + 1e-12
    return Quantity(
        id=c.id,
        unit=c.unit,
        description=c.description,
        initial=c.initial,
        lower=c.initial / THRESHOLDS.largest_inertia_over_guess if positive else c.initial - width,
        upper=c.initial * THRESHOLDS.largest_inertia_over_guess if positive else c.initial + width,
        prior=Normal(mean=c.initial, std=c.prior_std) if c.prior_std > 0 else None,
        fixed=c.prior_std == 0,
        scale="log" if positive else "linear",
        structured=structured or COUPLING.format(coefficient=c.id),
    )


def _diagonal(id: str) -> bool:
    """Whether ``M00_1`` names a diagonal entry."""
    digits = id[1:].partition("_")[0]
    half = len(digits) // 2
    return len(digits) % 2 == 0 and digits[:half] == digits[half:]


def coupled_equations(device: Device, motion: LockedDynamics, effects: Effects) -> Equations:
    """Build the equations of several free joints, solved for the accelerations.

    Parameters
    ----------
    device
        Device with drives, springs and friction laws.
    motion
        Equation of motion of the free joints.
    effects
        Effects by joint.

    Returns
    -------
    Equations
        v̇ = adj(M)·h/det(M) with h = torques − C·v − φ, and the parameters of all free joints.

    Raises
    ------
    InputError
        Where an effect needs a slot that the joint's friction law lacks.

    Notes
    -----
    The relaxation rate of a velocity is the joint's damping times the diagonal entry of M⁻¹.
    """
    joints = motion.joints
    parts = {j: joint_part(device, j, effects.get(j, ())) for j in joints}
    M = sp.Matrix(motion.mass_matrix) + sp.diag(*(part.inertia for part in parts.values()))
    load = [sp.expand(sp.expand(c) + g) for c, g in zip(motion.christoffel_force, motion.gravity_force, strict=True)]
    h = sp.Matrix([part.torque - bias for part, bias in zip(parts.values(), load, strict=True)])
    inverse_det, adjugate = 1 / M.det(method="berkowitz"), M.adjugate()
    acceleration = [(adjugate[i, :] * h)[0] * inverse_det for i in range(len(joints))]
    damping = [part.damping * adjugate[i, i] * inverse_det for i, part in enumerate(parts.values())]
    added = names_of(effects)
    return Equations(
        name="_".join((f"joints{''.join(map(str, joints))}", *added)),
        title=f"joints {', '.join(map(str, joints))}, all others locked"
        + (f", with {', '.join(added)}" if added else ""),
        joints=joints,
        states=joint_states(device, parts),
        inputs=joint_inputs(device, joints),
        outputs=joint_outputs(device, parts),
        parameters=(
            *map(inertial_quantity, motion.coefficients),
            *(q for part in parts.values() for q in part.quantities),
        ),
        rhs=joint_rows(parts, acceleration),
        rates=joint_rates(parts, damping),
        inertia=tuple(tuple(M[i, :]) for i in range(len(joints))),
        orderings=tuple(pair for part in parts.values() for pair in part.orderings),
        effects=added,
        friction=tuple(device.joints[j].friction for j in joints),
    )
