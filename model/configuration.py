"""From a device, its free joints and a posture to the equations that are simulated and fitted.

One free joint: the equation of `model.joint` with the coefficients of the locked motion as parameters. Several:
M(q)·v̇ = Kp·τ − C·v − φ − spring − friction, solved for v̇ by Cramer's rule, with ids that end in the joint's number
(``sigma0_0``, ``Ks_1``).
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from model.algebra import position_symbol, velocity_symbol
from model.device import Device, Guess
from model.equations import Equations, Input, Output, State
from model.joint import joint_equations
from model.locked import Coefficient, LockedDynamics, locked_motion
from model.lugre import LuGre, LuGreParameters, lugre
from model.parameters import TABLE, Row
from model.quantity import Normal, Quantity

INERTIAL = ("inertia", "gravity_cos", "gravity_sin")
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
    """Return a coefficient as a parameter: a moment of inertia is positive, all others lie within `SPREAD` of the guess."""
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


def joint_quantities(device: Device, joint: int, *, suffix: str = "", prefix: str = "") -> tuple[Quantity, ...]:
    """Return drive, spring and friction parameters of one joint: the device's guesses, the table's defaults for the rest."""
    given, slides = device.joints[joint].parameters, device.joints[joint].prismatic
    return tuple(_quantity(row, given.get(row.id), slides, suffix, prefix) for row in TABLE if row.id not in INERTIAL)


def _quantity(row: Row, guess: Guess | None, slides: bool, suffix: str, prefix: str) -> Quantity:
    if guess is None:
        guess = Guess(initial=row.initial, lower=row.lower, upper=row.upper, fixed=row.fixed)
    return Quantity(
        id=row.id + suffix,
        unit=row.prismatic_unit if slides else row.unit,
        description=row.description,
        initial=guess.initial,
        lower=max(guess.lower, row.lower),
        upper=min(guess.upper, row.upper),
        prior=Normal(mean=guess.initial, std=guess.std) if guess.std else None,
        fixed=guess.fixed,
        scale=row.scale,
        structured=prefix + row.structured,
    )


def joint_states(device: Device, joints: Sequence[int]) -> tuple[State, ...]:
    """Return positions, velocities and bristle deflections, joint by joint within each."""
    units = {j: "m" if device.joints[j].prismatic else "rad" for j in joints}
    return (
        *(_state(f"q{j}", units[j], f"position of joint {j}", f"joint{j}.position") for j in joints),
        *(_state(f"v{j}", f"{units[j]}/s", f"velocity of joint {j}", f"joint{j}.velocity") for j in joints),
        *(_bristle(j, units[j]) for j in joints),
    )


def _state(id: str, unit: str, description: str, structured: str) -> State:
    return State(id=id, unit=unit, description=description, structured=structured)


def _bristle(j: int, unit: str) -> State:
    name = f"joint{j}.friction.bristle"
    return State(id=f"z{j}", unit=unit, description=f"bristle deflection of joint {j}", nominal=1e-3, structured=name)


def joint_inputs(device: Device, joints: Sequence[int]) -> tuple[Input, ...]:
    """Return the commanded torques (forces)."""
    result = []
    for j in joints:
        what, unit = ("force", "N") if device.joints[j].prismatic else ("torque", "N m")
        text = f"commanded {what} of joint {j}"
        result.append(Input(id=f"tau{j}", unit=unit, description=text, structured=f"joint{j}.torque"))
    return tuple(result)


def joint_outputs(device: Device, joints: Sequence[int]) -> tuple[Output, ...]:
    """Return the position readings."""
    return tuple(
        Output(
            id=f"y{j}",
            unit="m" if device.joints[j].prismatic else "rad",
            description=f"position reading of joint {j}",
            expression=position_symbol(j),
            structured=f"joint{j}.reading",
        )
        for j in joints
    )


def joint_friction(joint: int) -> LuGre:
    """Return LuGre friction of one of several joints, its parameters' ids ending in ``_<joint>``."""
    p = {id: _symbol(f"{id}_{joint}") for id in ("sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc")}
    return lugre(velocity_symbol(joint), _symbol(f"z{joint}"), LuGreParameters(**p))


def net_torque(joint: int) -> sp.Expr:
    """Return Kp·τ − Ks·(q − epos) − friction of one of several joints."""
    Kp, tau, Ks, epos = (_symbol(name) for name in (f"Kp_{joint}", f"tau{joint}", f"Ks_{joint}", f"epos_{joint}"))
    return Kp * tau - Ks * (position_symbol(joint) - epos) - joint_friction(joint).force


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def coupled_equations(device: Device, motion: LockedDynamics) -> Equations:
    """Return the equations of several free joints, solved for the accelerations."""
    joints, M = motion.joints, sp.Matrix(motion.mass_matrix)
    load = [sp.expand(sp.expand(c) + g) for c, g in zip(motion.christoffel_force, motion.gravity_force, strict=True)]
    h = sp.Matrix([net_torque(j) - bias for j, bias in zip(joints, load, strict=True)])
    inverse_det, adjugate = 1 / M.det(method="berkowitz"), M.adjugate()
    acceleration = [(adjugate[i, :] * h)[0] * inverse_det for i in range(len(joints))]
    friction = [joint_friction(j) for j in joints]
    damping = [
        (_symbol(f"sigma1_{j}") + _symbol(f"sigma2_{j}")) * adjugate[i, i] * inverse_det for i, j in enumerate(joints)
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
