"""M, C·v and φ from Lagrange, from the tape and from Newton-Euler, against Pinocchio and against each other."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.algebra.trig_polynomials import velocity_symbol
from haptid.model.algebra.vectors import add, apply
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.rigid_body.base_parameters import full_lagrangian
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.forward_dynamics import HANDLE_FORCE, HANDLE_TORQUE, forward_dynamics
from haptid.model.rigid_body.inertial_parameters import pi_jacobian, pi_prior, standard_initial, to_pi, to_standard
from haptid.model.rigid_body.kinematics import base_poses
from haptid.model.rigid_body.lagrange import LinearForm
from haptid.model.rigid_body.newton_euler import inverse_dynamics
from haptid.model.rigid_body.regressor import regressor

URDF = Path(__file__).parents[3] / "model" / "device" / "built_in" / "arm6.urdf"


def inertials(device: Device, pi: np.ndarray) -> dict[str, tuple[float, ...]]:
    return {link.name: tuple(pi[10 * i : 10 * i + 10]) for i, link in enumerate(device.massive)}


def numeric(device, pi, q, v):
    """M (n, n) and bias (n,) by the recursions in floating point."""
    motors = tuple(pi[10 * len(device.massive) :])
    M = np.array(mass_matrix(device, Numbers(q), inertials(device, pi), motors), dtype=float)
    bias = np.array(inverse_dynamics(device, Numbers(q), inertials(device, pi), dict(enumerate(v)), {}), dtype=float)
    return M, bias


def evaluate(ring, form: LinearForm, pi: np.ndarray, q: np.ndarray) -> float:
    values = [f(q[j]) for j in ring.free for f in (np.cos, np.sin)]
    return sum(pi[k] * sum(float(c) * np.prod(np.power(values, m)) for m, c in p.items()) for k, p in form.items())


def lagrange(device, pi, q, v):
    """M and bias from the exact polynomials: C·v by the Christoffel symbols."""
    lagrangian = full_lagrangian(device)
    n = range(len(q))
    M = np.array([[evaluate(lagrangian.ring, lagrangian.entry(i, j), pi, q) for j in n] for i in n])
    bias = np.array([evaluate(lagrangian.ring, lagrangian.gravity(i), pi, q) for i in n])
    for (i, j, k), form in lagrangian.christoffel().items():
        bias[i] += evaluate(lagrangian.ring, form, pi, q) * v[j] * v[k] * (1 if j == k else 2)
    return M, bias


def compiled_tape(device):
    """A function (q, v, standard, force, torque) → M, bias, handle torque, position, quaternion."""
    tape, n = forward_dynamics(device), len(device.joints)
    q, v = sp.symbols(f"q0:{n}", real=True), tuple(velocity_symbol(j) for j in range(n))
    wanted = [tape.mass_matrix, tape.bias, tape.handle_torque, tape.position, tape.quaternion]
    parameters = [quantity.symbol for quantity in tape.parameters]
    return sp.lambdify(
        [q, v, parameters, HANDLE_FORCE, HANDLE_TORQUE], wanted, cse=lambda e: (list(tape.definitions), e)
    )


def states(device, seed, n):
    rng = np.random.default_rng(seed)
    return rng.uniform(-2, 2, (n, len(device.joints))), rng.uniform(-3, 3, (n, len(device.joints)))


def without_rod(device):
    links = tuple(dataclasses.replace(link, inertial=None) if link.name == "3" else link for link in device.links)
    return dataclasses.replace(device, links=links)


def pinocchio_model(device):
    """The serial part of a device in Pinocchio, from its own joint and inertia classes."""
    pin = pytest.importorskip("pinocchio")
    model = pin.Model()
    model.gravity = pin.Motion(np.array(device.gravity), np.zeros(3))
    frames, order = {"base": 0}, []
    for link in device.links:
        if link.inertial is None:
            continue
        placement = pin.SE3(pin.rpy.rpyToMatrix(*link.rpy), np.array(link.origin))
        (j,) = link.moved_by
        joint = model.addJoint(
            frames[link.parent], pin.JointModelRevoluteUnaligned(np.array(link.axis)), placement, link.name
        )
        m, x, y, z, xx, yy, zz, xy, xz, yz = link.inertial.initial
        inertia = pin.Inertia(m, np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        frames[link.name] = joint
        order.append(j)
    return pin, model, order


@pytest.mark.parametrize("name", ["freedom6s", "arm6"])
def test_pinocchio_agrees_on_a_thousand_states(name):
    device = load_device(name)
    device = without_rod(device) if name == "freedom6s" else device
    pin, model, order = pinocchio_model(device)
    data, pi, tape = model.createData(), pi_prior(device)[0], compiled_tape(device)
    worst = 0.0
    for q, v in zip(*states(device, 1, 1000), strict=True):
        M, bias, *_ = tape(q, v, standard_initial(device), np.zeros(3), np.zeros(3))
        pin.crba(model, data, q[order])
        M_pin = np.triu(data.M) + np.triu(data.M, 1).T
        bias_pin = pin.nonLinearEffects(model, data, q[order], v[order])
        M_ours, bias_ours = np.array(M, dtype=float)[np.ix_(order, order)], np.array(bias, dtype=float)[order]
        worst = max(worst, np.abs(M_ours - M_pin).max() / np.abs(M_pin).max())
        worst = max(worst, np.abs(bias_ours - bias_pin).max() / np.abs(bias_pin).max())
    assert pi.shape == (10 * len(device.massive),)
    assert worst < 1e-9


def test_pinocchio_reads_the_urdf_alike():
    pin = pytest.importorskip("pinocchio")
    device = load_device(URDF)
    model = pin.buildModelFromUrdf(str(URDF))
    data, pi = model.createData(), pi_prior(device)[0]
    for q, v in zip(*states(device, 2, 1000), strict=True):
        M, bias = numeric(device, pi, q, v)
        pin.crba(model, data, q)
        M_pin = np.triu(data.M) + np.triu(data.M, 1).T
        bias_pin = pin.nonLinearEffects(model, data, q, v)
        assert np.abs(M - M_pin).max() <= 1e-9 * np.abs(M_pin).max()
        assert np.abs(bias - bias_pin).max() <= 1e-9 * np.abs(bias_pin).max()


@pytest.mark.parametrize("name", ["freedom6s", "double_pendulum", "arm6"])
def test_lagrange_recursion_and_tape_are_one_model(name):
    device = load_device(name)
    pi, tape = pi_prior(device)[0], compiled_tape(device)
    for q, v in zip(*states(device, 3, 2), strict=True):
        M, bias = lagrange(device, pi, q, v)
        for other_M, other_bias in (
            numeric(device, pi, q, v),
            tape(q, v, standard_initial(device), np.zeros(3), np.zeros(3))[:2],
        ):
            np.testing.assert_allclose(np.array(other_M, dtype=float), M, rtol=0, atol=1e-12 * np.abs(M).max())
            np.testing.assert_allclose(np.array(other_bias, dtype=float), bias, rtol=0, atol=1e-11 * np.abs(bias).max())


def test_regressor_is_linear_in_the_parameters():
    device = load_device("double_pendulum")
    pi = pi_prior(device)[0]
    rng = np.random.default_rng(4)
    q, v, a = rng.normal(size=(3, 2, 5))
    torques = regressor(device, q, v, a) @ pi
    for n in range(5):
        M, bias = numeric(device, pi, q[:, n], v[:, n])
        np.testing.assert_allclose(torques[:, n], M @ a[:, n] + bias, rtol=1e-12)


def total_energy(device, pi, q, v):
    """½ vᵀMv − Σ m g·c with centroids in the base frame."""
    M, _ = numeric(device, pi, q, v)
    potential = 0.0
    for link, (R, p) in ((link, base_poses(device, Numbers(q))[link.name]) for link in device.massive):
        values = link.inertial.initial
        centroid = np.array(add(p, apply(R, values[1:4])), dtype=float)
        potential -= values[0] * np.dot(device.gravity, centroid)
    return 0.5 * v @ M @ v + potential


def test_full_model_with_the_rod_keeps_its_energy():
    device = load_device("freedom6s")
    tape, standard, zero = compiled_tape(device), standard_initial(device), np.zeros(3)

    def rhs(_, x):
        M, bias, *_ = tape(x[:6], x[6:], standard, zero, zero)
        return np.concatenate([x[6:], np.linalg.solve(np.array(M, dtype=float), -np.array(bias, dtype=float))])

    start = np.array([0.3, -0.4, 0.5, 0.2, -0.6, 0.4, 1.0, -1.5, 1.2, 2.0, -2.5, 1.7])
    run = solve_ivp(rhs, (0.0, 1.0), start, method="DOP853", rtol=1e-12, atol=1e-13)
    pi = pi_prior(device)[0]
    energies = np.array([total_energy(device, pi, x[:6], x[6:]) for x in run.y.T])
    kinetic = 0.5 * start[6:] @ numeric(device, pi, start[:6], start[6:])[0] @ start[6:]
    assert np.ptp(run.y[1]) > 0.5  # it moves
    assert np.abs(energies - energies[0]).max() <= 1e-9 * kinetic


ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6)


@settings(max_examples=50, deadline=None)
@given(q=ANGLES)
def test_mass_matrix_is_symmetric_and_positive_definite(q):
    device = load_device("freedom6s")
    M, _ = numeric(device, pi_prior(device)[0], np.array(q), np.zeros(6))
    np.testing.assert_allclose(M, M.T, rtol=0, atol=1e-15)
    assert np.linalg.eigvalsh(M)[0] > 0


@settings(max_examples=20, deadline=None)
@given(q=ANGLES, v=ANGLES)
def test_christoffel_form_is_passive(q, v):
    """vᵀ(Ṁ − 2C)v = 0: Ṁ by differences of the recursion, C·v from the bias without gravity."""
    device = dataclasses.replace(load_device("freedom6s"), gravity=(0.0, 0.0, 0.0))
    pi, q, v, h = pi_prior(device)[0], np.array(q), np.array(v), 1e-5
    slope = (numeric(device, pi, q + h * v, v)[0] - numeric(device, pi, q - h * v, v)[0]) / (2 * h)
    _, coriolis = numeric(device, pi, q, v)
    assert v @ slope @ v - 2 * v @ coriolis == pytest.approx(0.0, abs=1e-8 * (1 + v @ v) ** 1.5)


def test_handle_force_works_through_the_jacobian_of_the_control_point():
    device = load_device("freedom6s")
    tape, standard = compiled_tape(device), standard_initial(device)
    q, F = np.array([0.2, -0.3, 0.4, 0.1, -0.5, 0.3]), np.array([0.7, -1.1, 0.4])
    torque = np.array(tape(q, np.zeros(6), standard, F, np.zeros(3))[2], dtype=float)
    h = 1e-6
    for j in range(6):
        step = h * np.eye(6)[j]
        ahead, behind = (np.array(tape(x, np.zeros(6), standard, F, F)[3], dtype=float) for x in (q + step, q - step))
        assert torque[j] == pytest.approx(F @ (ahead - behind) / (2 * h), abs=1e-8)


def test_quaternion_turns_as_the_rotation_matrix():
    device = load_device("arm6")
    q = np.array([0.4, -0.7, 0.3, 0.9, -0.2, 1.1])
    w, x, y, z = compiled_tape(device)(q, np.zeros(6), standard_initial(device), np.zeros(3), np.zeros(3))[4]
    R, _ = base_poses(device, Numbers(q))[device.tip]
    expected = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    np.testing.assert_allclose(np.array(R, dtype=float), expected, atol=1e-12)


def test_published_double_pendulum():
    """M of the published arm in the closed form of its authors, reflected rotors included."""
    device = load_device("double_pendulum")
    I1, I2, m2, l1, r2, Ir, gr = 0.0535, 0.0239, 0.604, 0.3, 0.184, 7.66e-5, 6
    q = np.array([0.4, -0.9])
    M, _ = numeric(device, pi_prior(device)[0], q, np.zeros(2))
    c2 = np.cos(q[1])
    expected = np.array(
        [
            [I1 + I2 + m2 * l1**2 + 2 * m2 * l1 * r2 * c2 + gr**2 * Ir + Ir, I2 + m2 * l1 * r2 * c2 - gr * Ir],
            [I2 + m2 * l1 * r2 * c2 - gr * Ir, I2 + gr**2 * Ir],
        ]
    )
    np.testing.assert_allclose(M, expected, rtol=1e-4)  # the file rounds the inertias about the centroids


def test_tape_is_small():
    operations = sum(expression.count_ops() for _, expression in forward_dynamics(load_device("freedom6s")).definitions)
    assert operations < 2000


def test_to_pi_and_back():
    device = load_device("freedom6s")
    standard = standard_initial(device) + 1e-3
    np.testing.assert_allclose(to_standard(device, to_pi(device, standard)), standard, rtol=1e-12, atol=1e-15)
    J, h = pi_jacobian(device, standard), 1e-6
    numericJ = np.array(
        [(to_pi(device, standard + h * e) - to_pi(device, standard - h * e)) / (2 * h) for e in np.eye(standard.size)]
    ).T
    np.testing.assert_allclose(J, numericJ, atol=1e-9)
