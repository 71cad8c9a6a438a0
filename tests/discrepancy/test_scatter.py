"""Cycles' amplitudes on the torque: the linear model holds about the most probable ones, not about none."""

import numpy as np
import pytest

from discrepancy.cycles import whole_cycles
from discrepancy.kernels import Factory
from discrepancy.noise import Colour, Noise, Whitener, directions
from discrepancy.scatter import LARGEST, cycle_columns, relinearised, restricted_likelihood
from identification.simulator import initial_state
from measurement.run import Run
from model.joint import joint_equations

VALUES = {
    "inertia": 1.6e-4, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.018, "epos": 0.03, "sigma0": 0.5,
    "sigma1": 0.003, "sigma2": 1.3e-3, "vs": 0.06, "Fs": 1.5e-3, "Fc": 1.1e-3,
}  # fmt: skip
OMEGA = 2.0


def run_with(u: np.ndarray, y: np.ndarray, t: np.ndarray) -> Run:
    return Run(
        file="cosine", free_joints=(0,), t=t, u=u[:, None], y=y[:, None], noise=np.array([1e-4]),
        resolution=np.zeros(1), posture=np.zeros(1), use="fit",
    )  # fmt: skip


def test_amplitudes_are_found_and_leave_far_less_than_the_first_linearisation():
    equations = joint_equations(0)
    simulator, theta = Factory()(equations), np.array([VALUES[q.id] for q in equations.parameters])
    t = np.arange(0.0, 16.0, 0.01)
    u = 0.008 * np.cos(OMEGA * t)
    cycles = whole_cycles(run_with(u, np.zeros_like(t), t))
    assert cycles.count == 6  # 5.09 cycles: the last tenth of a cycle has an amplitude of its own
    rng = np.random.default_rng(2)
    b = 0.03 * rng.standard_normal(cycles.count)
    driven = run_with(u * np.exp(b[cycles.index]), np.zeros_like(t), t)
    x0 = initial_state(equations, driven)
    y = simulator.simulate(theta, driven, x0=x0).y[:, 0]
    run = run_with(u, y + 1e-4 * rng.standard_normal(t.size), t)
    noise = Noise(scatter=0.03, path="torque")

    about, M = relinearised(simulator, run, noise, theta, x0)
    found = np.log(np.array([about.u[cycles.index == k, 0][0] / u[cycles.index == k][0] for k in range(cycles.count)]))
    assert found[:5] == pytest.approx(b[:5], abs=2e-3)
    left = (about.y[:, 0] - simulator.simulate(theta, about, x0=x0).y[:, 0]) / 1e-4
    assert np.mean((left - M @ found) ** 2) < 1.1

    naive = cycle_columns(simulator, run, noise, theta, x0)
    r = (run.y[:, 0] - simulator.simulate(theta, run, x0=x0).y[:, 0]) / 1e-4
    rest = r - naive @ np.linalg.lstsq(naive, r, rcond=None)[0]
    assert np.mean(rest**2) > 2.0


def test_a_simulation_that_runs_away_has_no_directions_and_breaks_nothing():
    equations = joint_equations(0)
    simulator = Factory()(equations)
    theta = np.array([VALUES[q.id] for q in equations.parameters])
    theta[[q.id for q in equations.parameters].index("Ks")] = -1e6
    t = np.arange(0.0, 8.0, 0.01)
    run = run_with(0.008 * np.cos(OMEGA * t), np.zeros_like(t), t)
    x0 = np.array([1.0, 0.0, 0.0])

    about, M = relinearised(simulator, run, Noise(scatter=0.03, path="torque"), theta, x0)
    assert about is run
    assert not np.isfinite(M).all()
    assert Whitener.of(Colour(), 0.03, M) == Whitener()
    assert [part.size for part in restricted_likelihood(np.zeros(t.size), M)] == [0, 0]


def test_a_wrong_model_moves_no_cycle_beyond_where_its_torque_is_believable():
    equations = joint_equations(0)
    simulator, theta = Factory()(equations), np.array([VALUES[q.id] for q in equations.parameters])
    t = np.arange(0.0, 8.0, 0.01)
    run = run_with(0.008 * np.cos(OMEGA * t), np.full_like(t, 50.0), t)
    x0 = initial_state(equations, run.but(y=np.zeros((t.size, 1))))
    about, M = relinearised(simulator, run, Noise(scatter=0.5, path="torque"), theta, x0)
    assert np.isfinite(M).all()
    moved = np.abs(about.u[:, 0]) > np.abs(run.u[:, 0]) * np.exp(LARGEST) * (1 + 1e-9)
    assert not moved.any()


def test_directions_are_those_of_the_singular_value_decomposition_where_columns_repeat():
    rng = np.random.default_rng(5)
    M = rng.standard_normal((400, 6)) * np.array([1e3, 300.0, 30.0, 3.0, 1.0, 0.1])
    M = np.column_stack((M, M[:, :2]))
    U, d = directions(M)
    exact = np.linalg.svd(M)[1][:6]
    np.testing.assert_allclose(np.sort(d)[::-1], exact, rtol=1e-6)
    np.testing.assert_allclose(U.T @ U, np.eye(6), atol=1e-6)
