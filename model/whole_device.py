"""The equations of the whole device: all joints free, friction, springs, gains, handle force in, handle pose out."""

from __future__ import annotations

import sympy as sp

from model.algebra import velocity_symbol
from model.device import Device
from model.equations import Equations, Input, Output
from model.forward_dynamics import HANDLE_FORCE, HANDLE_TORQUE, ForwardDynamics, forward_dynamics
from model.joint_parts import (
    joint_friction,
    joint_inputs,
    joint_outputs,
    joint_quantities,
    joint_states,
    net_torque,
)


def full_equations(device: Device) -> Equations:
    """Return M(q)·v̇ = Kp·τ − C·v − φ − springs − friction + Jᵀ·(handle force, handle torque) of all joints.

    Outputs: positions, velocities, torques at the joints Kp·τ, control point in the base frame [m], orientation of the
    handle as a unit quaternion. Parameters: mass, centroid and inertia of each link, rotors, then those of each joint.
    """
    joints = tuple(range(len(device.joints)))
    body = forward_dynamics(device)
    rows = [net_torque(j) - body.bias[j] + body.handle_torque[j] for j in joints]
    friction = [joint_friction(j) for j in joints]
    damping = [
        (sp.Symbol(f"sigma1_{j}", real=True) + sp.Symbol(f"sigma2_{j}", real=True)) / body.mass_matrix[j][j]
        for j in joints
    ]
    return Equations(
        name=device.name,
        title=f"{device.title}: all joints free",
        joints=joints,
        states=joint_states(device, joints),
        inputs=(*joint_inputs(device, joints), *_handle_inputs()),
        outputs=(*joint_outputs(device, joints), *_motion_outputs(device), *_pose_outputs(body)),
        parameters=(
            *body.parameters,
            *(q for j in joints for q in joint_quantities(device, j, suffix=f"_{j}", prefix=f"joint{j}.")),
        ),
        rhs=(*(velocity_symbol(j) for j in joints), *rows, *(f.bristle for f in friction)),
        rates=(*(sp.S.Zero for _ in joints), *damping, *(f.rate for f in friction)),
        definitions=body.definitions,
        mass_matrix=body.mass_matrix,
        orderings=tuple((f"Fs_{j}", f"Fc_{j}") for j in joints),
    )


def _handle_inputs() -> tuple[Input, ...]:
    return tuple(
        Input(
            id=symbol.name,
            unit=unit,
            description=f"{what} on the handle along {symbol.name[-1]} of the base frame",
            structured=f"handle.{what}.{symbol.name[-1]}",
        )
        for what, unit, symbols in (("force", "N", HANDLE_FORCE), ("torque", "N m", HANDLE_TORQUE))
        for symbol in symbols
    )


def _motion_outputs(device: Device) -> tuple[Output, ...]:
    slides = [joint.prismatic for joint in device.joints]
    velocities = [
        Output(
            id=f"velocity{j}",
            unit="m/s" if slides[j] else "rad/s",
            description=f"velocity of joint {j}",
            expression=velocity_symbol(j),
            structured=f"joint{j}.speed",
        )
        for j in range(len(slides))
    ]
    torques = [
        Output(
            id=f"motor{j}",
            unit="N" if slides[j] else "N m",
            description=f"motor-side {'force' if slides[j] else 'torque'} of joint {j}, Kp times the command",
            expression=sp.Symbol(f"Kp_{j}", real=True) * sp.Symbol(f"tau{j}", real=True),
            structured=f"joint{j}.actuator.torque",
        )
        for j in range(len(slides))
    ]
    return (*velocities, *torques)


def _pose_outputs(body: ForwardDynamics) -> tuple[Output, ...]:
    position = [
        Output(
            id=f"handle_{axis}",
            unit="m",
            description=f"control point, {axis} in the base frame",
            expression=sp.sympify(value),
            structured=f"handle.position.{axis}",
        )
        for axis, value in zip("xyz", body.position, strict=True)
    ]
    orientation = [
        Output(
            id=f"handle_q{axis}",
            unit="1",
            description=f"orientation of the handle, quaternion component {axis}",
            expression=sp.sympify(value),
            structured=f"handle.quaternion.{axis}",
        )
        for axis, value in zip("wxyz", body.quaternion, strict=True)
    ]
    return (*position, *orientation)
