"""The arm against Pinocchio, against differentiated kinematics, against energy, and against the single joint."""

from dataclasses import replace

import numpy as np
import pytest

from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.joint import integrate
from haptid.virtual_device.machine.truth import DRIVE, LINK, Truth, inertia_tensor, read_truth
from haptid.virtual_device.machine.variation import is_usable, vary
from haptid.virtual_device.recording.inputs import AMPLITUDE

ORDER = [0, 1, 2, 3, 5, 4]  # joints from base to tip
STATES = 200


@pytest.fixture(scope="module")
def truth() -> Truth:
    return read_truth()


@pytest.fixture(scope="module")
def arm(truth: Truth) -> Arm:
    return Arm(truth)


def turn(axis: int, angle: float) -> np.ndarray:
    """Rodrigues' formula about a coordinate axis."""
    K = np.cross(np.eye(3), np.eye(3)[axis])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def poses(truth: Truth, q: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Orientation and centroid of every link, straight from the drawing."""
    upper, forearm, crank, *_ = truth.geometry
    R1 = turn(2, q[0])
    R2 = R1 @ turn(0, q[1])
    R4 = R1 @ turn(0, q[1] + q[2])
    R5 = R4 @ turn(2, q[3])
    R6 = R5 @ turn(0, q[5])
    R7 = R6 @ turn(1, q[4])
    elbow = R2 @ [0, 0, upper]
    wrist, pin = elbow - R4 @ [0, forearm, 0], R4 @ [0, crank, 0]
    origins = [np.zeros(3), np.zeros(3), pin, elbow, wrist, wrist, wrist]
    turned = [R1, R2, R2, R4, R5, R6, R7]
    return [(R, o + R @ row[1:4]) for R, o, row in zip(turned, origins, truth.links, strict=True)]


def test_mass_matrix_is_that_of_the_differentiated_kinematics_rod_included(truth: Truth, arm: Arm) -> None:
    rng, h = np.random.default_rng(1), 1e-6
    for _ in range(20):
        q, expected = rng.uniform(-1.5, 1.5, 6), np.zeros((6, 6))
        shifted = [(poses(truth, q + d), poses(truth, q - d)) for d in h * np.eye(6)]
        for link, (R, _) in enumerate(poses(truth, q)):
            J = np.array([(plus[link][1] - minus[link][1]) / (2 * h) for plus, minus in shifted]).T
            spins = [(plus[link][0] - minus[link][0]) / (2 * h) @ R.T for plus, minus in shifted]
            W = np.array([[S[2, 1], S[0, 2], S[1, 0]] for S in spins]).T
            expected += truth.links[link, 0] * J.T @ J + W.T @ R @ inertia_tensor(truth.links[link]) @ R.T @ W
        np.testing.assert_allclose(arm.dynamics(q, np.zeros(6))[0], expected, atol=1e-10)


def test_mass_matrix_is_symmetric_and_positive_definite(arm: Arm) -> None:
    rng = np.random.default_rng(2)
    for _ in range(STATES):
        M, _ = arm.dynamics(rng.uniform(-3, 3, 6), rng.normal(size=6))
        np.testing.assert_allclose(M, M.T, atol=1e-16)
        assert np.linalg.eigvalsh(M)[0] > 0


def test_serial_part_agrees_with_pinocchio(truth: Truth) -> None:
    pin = pytest.importorskip("pinocchio", reason="Pinocchio has no wheel for this platform")
    links = truth.links.copy()
    links[2] = 0.0  # the rod
    arm = Arm(replace(truth, links=links))
    upper, forearm = truth.geometry[:2]
    model, parent = pin.Model(), 0
    joints = [pin.JointModelRZ(), pin.JointModelRX(), pin.JointModelRX()]
    joints += [pin.JointModelRZ(), pin.JointModelRX(), pin.JointModelRY()]
    offsets = [np.zeros(3), np.zeros(3), np.array([0, 0, upper]), np.array([0, -forearm, 0]), np.zeros(3), np.zeros(3)]
    for number, row, joint, offset in zip(ORDER, links[[0, 1, 3, 4, 5, 6]], joints, offsets, strict=True):
        parent = model.addJoint(parent, joint, pin.SE3(np.eye(3), offset), f"joint{number}")
        model.appendBodyToJoint(parent, pin.Inertia(row[0], row[1:4], inertia_tensor(row)), pin.SE3.Identity())
    data, rng = model.createData(), np.random.default_rng(3)
    for _ in range(STATES):
        q, v = rng.uniform(-3, 3, 6), rng.normal(scale=3, size=6)
        M, h = arm.dynamics(q, v)
        full = np.array(pin.crba(model, data, q[ORDER]))
        full = np.triu(full) + np.triu(full, 1).T
        bias = np.array(pin.nle(model, data, q[ORDER], v[ORDER]))
        np.testing.assert_allclose(M[np.ix_(ORDER, ORDER)], full, rtol=0, atol=1e-12 * np.abs(full).max())
        np.testing.assert_allclose(h[ORDER], bias, rtol=0, atol=1e-12 * np.abs(bias).max())


def test_energy_is_conserved_without_friction(truth: Truth) -> None:
    drives = truth.drives.copy()
    for key in ("sigma0", "sigma1", "sigma2"):
        drives[:, DRIVE.index(key)] = 0.0
    arm, joints = Arm(replace(truth, drives=drives)), tuple(range(6))
    state = arm.start(np.array([0.3, -0.4, 0.5, 0.6, -0.7, 0.4]), np.array([0.5, 1.0, -1.0, 2.0, 3.0, -2.0]))

    def energy() -> float:
        q, v = state[:6], state[6:12]
        stretch = q - drives[:, DRIVE.index("epos")]
        spring = 0.5 * np.sum(drives[:, DRIVE.index("Ks")] * stretch**2)
        return float(0.5 * v @ arm.dynamics(q, v)[0] @ v + arm.potential(q) + spring)

    first, kinetic = energy(), 0.0
    for _ in range(40):
        arm.advance(joints, state, np.zeros(6), 0.05)
        kinetic = max(kinetic, float(0.5 * state[6:12] @ arm.dynamics(state[:6], state[6:12])[0] @ state[6:12]))
        assert abs(energy() - first) < 1e-9 * kinetic + 1e-13


@pytest.mark.parametrize("joint", range(6))
def test_arm_with_one_joint_free_is_the_single_joint(arm: Arm, joint: int) -> None:
    posture = np.array([0.1, -0.2, 0.15, 0.3, -0.1, 0.25])
    t = np.arange(401) * 0.005
    torque = AMPLITUDE[joint] * np.cos(2.0 * t)
    start = arm.rest((joint,), posture)
    state = arm.start(start)
    moved = [start[joint]]
    for u in torque[:-1]:
        arm.advance((joint,), state, np.where(np.arange(6) == joint, u, 0.0), 0.005)
        moved.append(state[joint])
    alone = integrate(arm.locked_joint(joint, posture), t, torque, start=(start[joint], 0.0))[0]
    locked = [j for j in range(6) if j != joint]
    np.testing.assert_array_equal(state[locked], posture[locked])
    np.testing.assert_allclose(moved, alone, atol=1e-8)


def test_handle_hangs_where_the_drawing_says(arm: Arm) -> None:
    np.testing.assert_allclose(arm.handle(np.zeros(6)), [0.0, -0.28, 0.2], atol=1e-15)
    np.testing.assert_allclose(arm.handle(np.array([np.pi / 2, 0, 0, 0, 0, 0])), [0.28, 0.0, 0.2], atol=1e-15)


def test_other_machines_are_other_bodies_and_repeat(truth: Truth) -> None:
    first, again = (vary(truth, 0.3, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(first.links, again.links)
    assert is_usable(first)
    assert np.all(first.links[:, LINK.index("mass")] != truth.links[:, LINK.index("mass")])
