"""Equations of a few free joints and of the whole device, put together right: solved, rubbed, driven and pushed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import sympy as sp

from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.rigid_body.locked_dynamics import locked_motion

DEVICE = load_device("freedom6s")
JOINT_IDS = ("sigma0", "sigma1", "sigma2", "vs", "Fs", "Fc", "Ks", "epos")


@cache
def whole() -> tuple[Equations, CompiledKernel]:
    e = full_equations(DEVICE)
    return e, CompiledKernel.of(e)


def lugre_by_hand(p: dict[str, float], v: float, z: float) -> tuple[float, float]:
    """Rate of the bristle and friction torque."""
    rate = v - p["sigma0"] * abs(v) / (p["Fc"] + (p["Fs"] - p["Fc"]) * np.exp(-((v / p["vs"]) ** 2))) * z
    return rate, p["sigma0"] * z + p["sigma1"] * rate + p["sigma2"] * v


@pytest.mark.parametrize("seed", range(5))
def test_coupled_joints_solve_the_mass_matrix(seed: int):
    rng = np.random.default_rng(seed)
    e, motion = configuration_equations(DEVICE, [1, 0]), locked_motion(DEVICE, [0, 1])
    p = {q.id: q.initial for q in e.parameters}
    q, v, z, tau = rng.normal(0, 0.3, 2), rng.normal(0, 0.5, 2), rng.normal(0, 1e-3, 2), rng.normal(0, 0.05, 2)
    values = {sp.Symbol(f"q{i}", real=True): q[i] for i in range(2)}
    values |= {sp.Symbol(f"v{i}", real=True): v[i] for i in range(2)}
    values |= {c.symbol: p[c.id] for c in motion.coefficients}
    M, load = (
        np.array(x.subs(values), dtype=float)
        for x in (motion.mass_matrix, motion.christoffel_force + motion.gravity_force)
    )
    own = [{id: p[f"{id}_{i}"] for id in JOINT_IDS} for i in range(2)]
    friction = [lugre_by_hand(own[i], v[i], z[i]) for i in range(2)]
    spring = [own[i]["Ks"] * (q[i] - own[i]["epos"]) for i in range(2)]
    acceleration = np.linalg.solve(M, tau - load[:, 0] - spring - [f for _, f in friction])
    f = CompiledKernel.of(e).derivatives(0.0, np.r_[q, v, z], tau, list(p.values()))
    np.testing.assert_allclose(f, np.r_[v, acceleration, [dz for dz, _ in friction]], rtol=1e-10, atol=1e-10)


def test_one_joint_has_the_coefficients_it_needs_and_the_devices_guesses():
    vertical, roll = configuration_equations(DEVICE, [0]), configuration_equations(DEVICE, [4])
    assert "gravity_cos" not in {q.id for q in vertical.parameters}
    assert roll.parameter("gravity_sin").prior is not None
    assert roll.parameter("Ks").upper == DEVICE.joints[4].parameters["Ks"].upper
    assert roll.parameter("inertia").scale == "log"


def test_the_posture_changes_what_is_felt():
    home, bent = (configuration_equations(DEVICE, [0], posture) for posture in (None, [0, 0.5, 0.3, 0, 0, 0]))
    assert abs(bent.parameter("inertia").initial / home.parameter("inertia").initial - 1) > 1e-2


def random_state(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.r_[rng.normal(0, 0.3, 6), rng.normal(0, 0.5, 6), rng.normal(0, 1e-4, 6)]


def inputs(**values: float) -> np.ndarray:
    e, _ = whole()
    u = np.zeros(len(e.inputs))
    for id, value in values.items():
        u[[x.id for x in e.inputs].index(id)] = value
    return u


def accelerations_per_torque(k: CompiledKernel, x: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Accelerations with 1 N m at one joint after the other, shape (6, 6)."""
    return np.column_stack([k.derivatives(0.0, x, inputs(**{f"tau{j}": 1.0}), p)[6:12] for j in range(6)])


@pytest.mark.parametrize("seed", range(3))
def test_a_handle_force_does_the_work_of_its_jacobian(seed: int):
    e, k = whole()
    p, x, h = np.array([q.initial for q in e.parameters]), random_state(seed), 1e-6
    at = [[o.id for o in e.outputs].index(f"handle_{axis}") for axis in "xyz"]
    rest = k.derivatives(0.0, x, inputs(), p)[6:12]
    per_torque = accelerations_per_torque(k, x, p) - rest[:, None]
    J = np.column_stack(
        [
            (k.output(0.0, x + h * step, inputs(), p)[at] - k.output(0.0, x - h * step, inputs(), p)[at]) / (2 * h)
            for step in np.eye(18)[:6]
        ]
    )
    force = np.random.default_rng(seed).normal(size=3)
    pushed = k.derivatives(0.0, x, inputs(**{f"handle_force_{a}": f for a, f in zip("xyz", force, strict=True)}), p)
    np.testing.assert_allclose(
        pushed[6:12] - rest, per_torque @ J.T @ force, rtol=1e-6, atol=1e-6 * np.abs(pushed).max()
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_handle_torque_does_the_work_of_the_handles_rotation(seed: int):
    e, k = whole()
    p, x, h = np.array([q.initial for q in e.parameters]), random_state(seed), 1e-6
    at = [[o.id for o in e.outputs].index(f"handle_q{axis}") for axis in "wxyz"]
    w, *vector = k.output(0.0, x, inputs(), p)[at]
    columns = []
    for step in np.eye(18)[:6]:
        dq = (k.output(0.0, x + h * step, inputs(), p)[at] - k.output(0.0, x - h * step, inputs(), p)[at]) / (2 * h)
        columns.append(2 * (w * dq[1:] - dq[0] * np.array(vector) + np.cross(vector, dq[1:])))
    rest = k.derivatives(0.0, x, inputs(), p)[6:12]
    per_torque = accelerations_per_torque(k, x, p) - rest[:, None]
    torque = np.random.default_rng(seed).normal(size=3)
    turned = k.derivatives(0.0, x, inputs(**{f"handle_torque_{a}": f for a, f in zip("xyz", torque, strict=True)}), p)
    expected = per_torque @ np.column_stack(columns).T @ torque
    np.testing.assert_allclose(turned[6:12] - rest, expected, rtol=1e-6, atol=1e-6 * np.abs(turned).max())


def test_a_locked_joint_of_the_whole_device_moves_as_its_own_equation():
    """With the others held by the torques that it takes, the free joint accelerates as its locked equation says."""
    e, k = whole()
    p, x = np.array([q.initial for q in e.parameters]), np.zeros(18)
    x[[4, 10, 16]] = 0.2, 0.3, 1e-4
    rest = k.derivatives(0.0, x, inputs(), p)[6:12]
    per_torque = accelerations_per_torque(k, x, p) - rest[:, None]
    held = [0, 1, 2, 3, 5]
    torques = np.linalg.solve(per_torque[np.ix_(held, held)], -rest[held])
    acceleration = rest[4] + per_torque[4, held] @ torques
    alone = configuration_equations(DEVICE, [4])
    f = CompiledKernel.of(alone).derivatives(0.0, [0.2, 0.3, 1e-4], [0.0], [q.initial for q in alone.parameters])
    assert acceleration == pytest.approx(f[1], rel=1e-9)


def test_motor_side_torques_are_outputs():
    e, k = whole()
    p = np.array([q.initial * (2.0 if q.id == "Kp_3" else 1.0) for q in e.parameters])
    y = k.output(0.0, np.zeros(18), inputs(tau3=0.01), p)
    assert y[[o.id for o in e.outputs].index("motor3")] == pytest.approx(0.02)
