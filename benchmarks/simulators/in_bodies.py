"""A device in MuJoCo and Pinocchio: mass matrix and bias beside haptid's own, and motions under recorded torques."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from haptid.fmu_build.multibody.bodies import Hinge, Multibody
from haptid.fmu_build.multibody.mjcf import name_of_sum
from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.device.device import Device
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.inertial_parameters import to_pi
from haptid.model.rigid_body.newton_euler import inverse_dynamics

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A motion of a device in MuJoCo.

    Parameters
    ----------
    positions
        Joint positions at the rows [rad], shape (n_t, n_q).
    handle
        Control point at the rows [m], shape (n_t, 3).
    slip
        Largest distance of a passive link from where its joint puts it [rad].
    """

    positions: Array
    handle: Array
    slip: float


def own_terms(device: Device, machine: Multibody, q: Array, v: Array) -> tuple[Array, Array]:
    """Return haptid's mass matrix (n_q, n_q) and bias C·v + φ (n_q,) at the values of a multibody."""
    links = [body.inertial for body in machine.bodies if body.inertial is not None]
    standard = [x for link in links for x in (link.mass, *link.centroid, *link.inertia)]
    pi = to_pi(device, np.array([*standard, *(rotor.inertia for rotor in machine.rotors)]))
    inertials = {link.name: tuple(pi[10 * i : 10 * i + 10]) for i, link in enumerate(device.massive)}
    motors = tuple(pi[10 * len(device.massive) :])
    M = np.array(mass_matrix(device, Numbers(q), inertials, motors), dtype=float)
    bias = np.array(inverse_dynamics(device, Numbers(q), inertials, dict(enumerate(v)), {}), dtype=float)
    return M, bias


def spread_of(machine: Multibody, names: Sequence[str]) -> Array:
    """Return S with (coordinates of all hinges) = S·q, shape (n_hinges, n_q)."""
    moved: dict[str, tuple[Hinge, ...]] = {hinge.name: (hinge,) for body in machine.bodies for hinge in body.hinges}
    moved |= {name_of_sum(body): body.hinges for body in machine.bodies}
    S = np.zeros((len(names), len(machine.axes)))
    for row, name in enumerate(names):
        for hinge in moved[name]:
            S[row, hinge.joint] = hinge.ratio
    return S


def mujoco_terms(model: Any, machine: Multibody, q: Array, v: Array) -> tuple[Array, Array]:
    """Return MuJoCo's mass matrix and bias, projected on the device's joints: Sᵀ·M·S and Sᵀ·bias."""
    data = mujoco.MjData(model)
    S = spread_of(machine, [model.joint(i).name for i in range(model.njnt)])
    data.qpos[:], data.qvel[:] = S @ q, S @ v
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    return S.T @ M @ S, S.T @ data.qfrc_bias


def pinocchio_terms(urdf: Path, q: Array, v: Array) -> tuple[Array, Array]:
    """Return Pinocchio's mass matrix and bias of a URDF, mimicking joints included."""
    import pinocchio  # noqa: PLC0415 # published for some platforms only, and not needed for motions

    model = pinocchio.buildModelFromUrdf(str(urdf), mimic=True)
    data = model.createData()
    joints = [model.joints[model.getJointId(f"joint{j}")] for j in range(len(q))]
    rows = [joint.idx_v for joint in joints]
    all_q, all_v = np.zeros(model.nq), np.zeros(model.nv)
    for j, joint in enumerate(joints):
        all_q[joint.idx_q], all_v[joint.idx_v] = q[j], v[j]
    pinocchio.crba(model, data, all_q)
    M = np.triu(data.M) + np.triu(data.M, 1).T
    bias = pinocchio.rnea(model, data, all_q, all_v, np.zeros(model.nv))
    return M[np.ix_(rows, rows)], bias[rows]


def motion(model: Any, machine: Multibody, t: Array, u: Array, start: Array) -> Motion:
    """Return the motion under torques that are held between the rows.

    Parameters
    ----------
    model
        Compiled MJCF of the machine, or its URDF.
    machine
        The device.
    t, u
        Rows [s], a whole number of the model's steps apart, and torques [N m], shape (n_t, n_q).
    start
        Positions at the first row [rad]; the device rests.
    """
    data = mujoco.MjData(model)
    S = spread_of(machine, [model.joint(i).name for i in range(model.njnt)])
    leads = [model.joint(axis.name).qposadr[0] for axis in machine.axes]
    data.qpos[:] = S @ start
    mujoco.mj_forward(model, data)
    positions, handle, slip = [], [], 0.0
    for k in range(t.size):
        positions.append(data.qpos[leads].copy())
        handle.append(data.site("control_point").xpos.copy())
        slip = max(slip, float(np.abs(data.qpos - S @ data.qpos[leads]).max()))
        if k + 1 < t.size:
            data.ctrl[: u.shape[1]] = u[k]
            steps = round((t[k + 1] - t[k]) / model.opt.timestep)
            mujoco.mj_step(model, data, steps)
            # the poses of an integrator's last stage are not those of the end
            mujoco.mj_kinematics(model, data)
    return Motion(positions=np.array(positions), handle=np.array(handle), slip=slip)
