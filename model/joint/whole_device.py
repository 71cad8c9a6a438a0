"""The equations of the whole device with all joints free: handle force as an input, handle pose as an output.

`Device` and effects by joint come in, implicit `Equations` with a mass matrix go out.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from haptid.model.algebra.trig_polynomials import velocity_symbol
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations, Input, Output
from haptid.model.equations.fmu_names import ACTUATOR_TORQUE, HANDLE, SPEED, of_joint
from haptid.model.joint.joint_in_device import (
    Effects,
    JointPart,
    joint_inputs,
    joint_outputs,
    joint_part,
    joint_rates,
    joint_rows,
    joint_states,
    names_of,
)
from haptid.model.rigid_body.forward_dynamics import HANDLE_FORCE, HANDLE_TORQUE, ForwardDynamics, forward_dynamics


def full_equations(device: Device, effects: Effects | None = None) -> Equations:
    """Build M(q)·v̇ = Kp·τ − C·v − φ − springs − friction + Jᵀ·(handle force, handle torque) of all joints.

    Parameters
    ----------
    device
        Device with n_q joints.
    effects
        Effects by joint, added as in `model.joint.joint_in_device.joint_part`.

    Returns
    -------
    Equations
        Implicit equations. Inputs: commands, then force [N] and torque [N m] on the handle in the base frame. Outputs:
        positions, velocities, torques at the joints Kp·τ, control point in the base frame [m], orientation of the
        handle as a unit quaternion. Parameters: mass, centroid and inertia of each link, rotors, then those of each
        joint.

    Raises
    ------
    InputError
        Where an effect needs a slot that its joint's friction law lacks.
    """
    joints = tuple(range(len(device.joints)))
    parts = {j: joint_part(device, j, (effects or {}).get(j, ())) for j in joints}
    body = forward_dynamics(device)
    M = sp.Matrix(body.mass_matrix) + sp.diag(*(part.inertia for part in parts.values()))
    rows = [part.torque - body.bias[j] + body.handle_torque[j] for j, part in parts.items()]
    added = names_of(effects or {})
    return Equations(
        name="_".join((device.name, *added)),
        title=f"{device.title}: all joints free" + (f", with {', '.join(added)}" if added else ""),
        joints=joints,
        states=joint_states(device, parts),
        inputs=(*joint_inputs(device, joints), *_handle_inputs()),
        outputs=(*joint_outputs(device, parts), *_motion_outputs(device, parts), *_pose_outputs(body)),
        parameters=(*body.parameters, *(q for part in parts.values() for q in part.quantities)),
        rhs=joint_rows(parts, rows),
        rates=joint_rates(parts, [part.damping / M[j, j] for j, part in parts.items()]),
        definitions=body.definitions,
        mass_matrix=tuple(tuple(M[i, :]) for i in joints),
        orderings=tuple(pair for part in parts.values() for pair in part.orderings),
        effects=added,
        friction=tuple(joint.friction for joint in device.joints),
    )


def _handle_inputs() -> tuple[Input, ...]:
    return tuple(
        Input(
            id=symbol.name,
            unit=unit,
            description=f"{what} on the handle along {symbol.name[-1]} of the base frame",
            structured=HANDLE.format(what=what, axis=symbol.name[-1]),
        )
        for what, unit, symbols in (("force", "N", HANDLE_FORCE), ("torque", "N m", HANDLE_TORQUE))
        for symbol in symbols
    )


def _motion_outputs(device: Device, parts: Mapping[int, JointPart]) -> tuple[Output, ...]:
    slides = [joint.prismatic for joint in device.joints]
    velocities = [
        Output(
            id=f"velocity{j}",
            unit="m/s" if slides[j] else "rad/s",
            description=f"velocity of joint {j}",
            expression=velocity_symbol(j),
            structured=of_joint(j, SPEED),
        )
        for j in range(len(slides))
    ]
    torques = [
        Output(
            id=f"motor{j}",
            unit="N" if slides[j] else "N m",
            description=f"motor-side {'force' if slides[j] else 'torque'} of joint {j}, Kp times the command",
            expression=part.motor,
            structured=of_joint(j, ACTUATOR_TORQUE),
        )
        for j, part in parts.items()
    ]
    return (*velocities, *torques)


def _pose_outputs(body: ForwardDynamics) -> tuple[Output, ...]:
    position = [
        Output(
            id=f"handle_{axis}",
            unit="m",
            description=f"control point, {axis} in the base frame",
            expression=sp.sympify(value),
            structured=HANDLE.format(what="position", axis=axis),
        )
        for axis, value in zip("xyz", body.position, strict=True)
    ]
    orientation = [
        Output(
            id=f"handle_q{axis}",
            unit="1",
            description=f"orientation of the handle, quaternion component {axis}",
            expression=sp.sympify(value),
            structured=HANDLE.format(what="quaternion", axis=axis),
        )
        for axis, value in zip("wxyz", body.quaternion, strict=True)
    ]
    return (*position, *orientation)
