"""The whole device as a tape for the 6-DOF FMU: mass matrix, bias, pose of the control point, torque of a force at it.

M(q)·v̇ = Σ torques + Jᵀ·(handle force) − bias,   bias = C(q, v)·v + φ(q).
Positions are q<j>, velocities v<j>; parameters are the standard ones of every link (``link4_m``, ``link4_x``, …,
``link4_I23``) and ``motor_<name>_J``. The numbers of the geometry are folded in.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy as sp

from haptid.model.algebra.expression_tape import Tape
from haptid.model.algebra.rational_rotations import rational_vector
from haptid.model.algebra.trig_polynomials import velocity_symbol
from haptid.model.algebra.vectors import Mat, Scalar, Vec, add, apply, cross, dot, plus, times, transpose
from haptid.model.device.device import BASE, LINK_UNITS, STANDARD, Device
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.rigid_body.body import Inertials
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.inertial_parameters import barycentric, standard_ids
from haptid.model.rigid_body.kinematics import base_poses, constant_vector, poses
from haptid.model.rigid_body.newton_euler import inverse_dynamics
from haptid.model.rigid_body.quaternion import orientation

HANDLE_FORCE = tuple(sp.Symbol(f"handle_force_{axis}", real=True) for axis in "xyz")
"""Force on the control point, in the base frame [N]."""
HANDLE_TORQUE = tuple(sp.Symbol(f"handle_torque_{axis}", real=True) for axis in "xyz")
"""Torque on the control link, in the base frame [N m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForwardDynamics:
    """Definitions of the rigid-body dynamics, and expressions in their symbols.

    Parameters
    ----------
    definitions
        Pairs (symbol, expression) in order, each expression of model symbols and earlier definitions.
    mass_matrix
        M, shape (n_q, n_q).
    bias
        C·v + φ, shape (n_q,).
    handle_torque
        Jᵀ times (HANDLE_FORCE, HANDLE_TORQUE), shape (n_q,).
    position
        Control point in the base frame [m], shape (3,).
    quaternion
        Orientation of the control link in the base frame (w, x, y, z).
    parameters
        The links' and motors' Quantities, with bounds and priors.
    """

    definitions: tuple[tuple[sp.Symbol, sp.Expr], ...]
    mass_matrix: tuple[tuple[sp.Expr, ...], ...]
    bias: tuple[sp.Expr, ...]
    handle_torque: tuple[sp.Expr, ...]
    position: tuple[sp.Expr, ...]
    quaternion: tuple[sp.Expr, ...]
    parameters: tuple[Quantity, ...]


def forward_dynamics(device: Device) -> ForwardDynamics:
    """Record the dynamics of a device on one expression tape.

    The mass matrix comes from composite rigid bodies, the bias from Newton-Euler without accelerations.

    Parameters
    ----------
    device
        Device with n_q joints.

    Returns
    -------
    ForwardDynamics
        Definitions and the expressions of M, bias, handle torque and pose.
    """
    tape, n = Tape(device), len(device.joints)
    inertials = _inertials(device, tape)
    motors = tuple(tape.symbol(_symbol(f"motor_{motor.name}_J")) for motor in device.motors)
    M = mass_matrix(device, tape, inertials, motors)
    bias = inverse_dynamics(device, tape, inertials, {j: tape.symbol(velocity_symbol(j)) for j in range(n)}, {})
    R, origin = base_poses(device, tape)[device.tip]
    point = constant_vector(tape, rational_vector(device.control_point))
    position = add(origin, apply(R, point))
    handle = _handle_torque(device, tape, R, point)
    wanted = [
        *(M[i][j] for i in range(n) for j in range(n)),
        *bias,
        *handle,
        *position,
        *orientation(device, tape, device.tip),
    ]
    definitions, results = tape.definitions(wanted)
    # taken in the order of ``wanted``: keyword arguments are evaluated from left to right
    rows = iter(results)
    return ForwardDynamics(
        definitions=definitions,
        mass_matrix=tuple(_take(rows, n) for _ in range(n)),
        bias=_take(rows, n),
        handle_torque=_take(rows, n),
        position=_take(rows, 3),
        quaternion=_take(rows, 4),
        parameters=link_quantities(device),
    )


def _take(rows: Iterator[sp.Expr], n: int) -> tuple[sp.Expr, ...]:
    return tuple(next(rows) for _ in range(n))


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def _inertials(device: Device, tape: Tape) -> Inertials:
    return {
        link.name: barycentric([tape.symbol(_symbol(f"link{link.name}_{key}")) for key in STANDARD])
        for link in device.massive
    }


def _handle_torque(device: Device, tape: Tape, R: Mat, point: Vec) -> tuple[Scalar, ...]:
    """Return the joint torques of a wrench at the control point, carried from the tip to the base."""
    placed = poses(device, tape)
    force: Vec = tuple(tape.symbol(symbol) for symbol in HANDLE_FORCE)  # type: ignore[assignment]  # three symbols
    torque: Vec = tuple(tape.symbol(symbol) for symbol in HANDLE_TORQUE)  # type: ignore[assignment]
    F = apply(transpose(R), force)
    N = add(apply(transpose(R), torque), cross(point, F))
    result: list[Scalar] = [0] * len(device.joints)
    name = device.tip
    while name != BASE:
        link, here = device.link(name), placed[name]
        along = dot(here.axis, N if link.motion == "revolute" else F)
        for j, ratio in link.moved_by.items():
            result[j] = plus(result[j], times(tape.constant(ratio), along))
        F = apply(here.R, F)
        N = add(apply(here.R, N), cross(here.p, F))
        name = link.parent
    return tuple(result)


def link_quantities(device: Device) -> tuple[Quantity, ...]:
    """Return the standard inertial parameters of links and motors as rows of a parameter table.

    Parameters
    ----------
    device
        Device with first guesses, bounds and prior standard deviations.

    Returns
    -------
    tuple of Quantity
        Parameters in the order of `standard_ids`, shape (n_pi,).
    """
    guesses = [guess for link in device.massive if link.inertial for guess in link.inertial.guesses]
    guesses += [motor.inertia for motor in device.motors]
    units = [*LINK_UNITS * len(device.massive), *("kg m^2",) * len(device.motors)]
    return tuple(
        Quantity(
            id=key,
            unit=unit,
            description=_description(key),
            initial=guess.initial,
            lower=guess.lower,
            upper=guess.upper,
            prior=Normal(mean=guess.initial, std=guess.std) if guess.std else None,
            fixed=guess.fixed,
            structured=_structured_name(key),
        )
        for key, unit, guess in zip(standard_ids(device), units, guesses, strict=True)
    )


def _structured_name(key: str) -> str:
    owner, _, parameter = key.rpartition("_")
    return f"{owner}.{parameter}"


def _description(key: str) -> str:
    owner, _, parameter = key.rpartition("_")
    if owner.startswith("motor_"):
        return f"Rotor inertia of motor {owner.removeprefix('motor_')}"
    what = {"m": "mass", **dict.fromkeys("xyz", f"centroid, {parameter}")}.get(
        parameter, f"inertia about the centroid, {parameter[1:]}"
    )
    return f"Link {owner.removeprefix('link')}: {what}"
