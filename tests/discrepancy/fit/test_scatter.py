"""Cycles' amplitudes on the torque: the linear model holds about the most probable ones, not about none."""

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from scipy.linalg import block_diag, null_space

from haptid.discrepancy.fit.scatter import (
    cycle_columns,
    cycles_of,
    degrees_of_freedom,
    most_probable,
    relinearise_cycles,
)
from haptid.discrepancy.study.coupled_study import coupled_study_of
from haptid.discrepancy.study.simulators import Factory
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.protocol import initial_state
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.noise.correlation import Arma, Noise, Scatter, Whitener, directions
from haptid.noise.reml import best_scatter
from haptid.noise.thresholds import THRESHOLDS as OF_NOISE
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.campaign import header
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import write_campaign
from haptid.virtual_device.recording.whole import coupled_test

VALUES = {
    "inertia": 1.6e-4, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.018, "epos": 0.03, "sigma0": 0.5,
    "sigma1": 0.003, "sigma2": 1.3e-3, "vs": 0.06, "Fs": 1.5e-3, "Fc": 1.1e-3,
}  # fmt: skip
OMEGA = 2.0
SCATTER = Scatter(size=0.03, path="torque")
NOISE = Noise(scatters=(SCATTER,))


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
    np.testing.assert_array_equal(cycles.index, np.floor(OMEGA * t / (2 * np.pi)))
    assert cycles.count == 6  # 5.09 cycles: the last tenth of a cycle has an amplitude of its own
    rng = np.random.default_rng(2)
    b = 0.03 * rng.standard_normal(cycles.count)
    driven = run_with(u * np.exp(b[cycles.index]), np.zeros_like(t), t)
    x0 = initial_state(equations, driven)
    y = simulator.simulate(theta, driven, x0=x0).y[:, 0]
    run = run_with(u, y + 1e-4 * rng.standard_normal(t.size), t)

    about, S = relinearise_cycles(simulator, run, NOISE, theta, x0)
    found = np.log(np.array([about.u[cycles.index == k, 0][0] / u[cycles.index == k][0] for k in range(cycles.count)]))
    assert found[:5] == pytest.approx(b[:5], abs=2e-3)
    left = (about.y[:, 0] - simulator.simulate(theta, about, x0=x0).y[:, 0]) / 1e-4
    assert np.mean((left - S[:, 0] @ found / SCATTER.size) ** 2) < 1.1

    naive = cycle_columns(simulator, run, SCATTER, theta, x0)[:, 0]
    r = (run.y[:, 0] - simulator.simulate(theta, run, x0=x0).y[:, 0]) / 1e-4
    rest = r - naive @ np.linalg.lstsq(naive, r, rcond=None)[0]
    assert np.mean(rest**2) > 2.0


@pytest.mark.parametrize("phase", [0.0, -0.01])
@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_columns_are_those_of_whole_simulations_until_a_cycle_is_forgotten(
    hold: Literal["zero", "linear"], phase: float
):
    """Where the phase is below 0, the first row is a cycle of its own, which moves the later ones alone."""
    equations = joint_equations(0)
    simulator, theta = Factory()(equations), np.array([VALUES[q.id] for q in equations.parameters])
    t = np.arange(0.0, 20.0, 0.01)
    run = run_with(0.008 * np.cos(OMEGA * t + phase), np.zeros_like(t), t).but(hold=hold)
    x0 = initial_state(equations, run)
    plain, M = (simulator.coarse.simulate(theta, run, x0=x0).y, cycle_columns(simulator, run, SCATTER, theta, x0))
    cycles = cycles_of(run, SCATTER).inside
    assert (cycles[:, 0].sum() == 1) == (phase < 0.0)
    for c, mask in enumerate(cycles.T):
        u = run.u.copy()
        u[mask] *= 1.0 + OF_NOISE.torque_change_of_scatter
        moved = simulator.coarse.simulate(theta, run.but(u=u), x0=x0).y
        whole = (moved - plain)[:, :1] / OF_NOISE.torque_change_of_scatter / 1e-4
        simulated = M[..., c] != 0.0
        np.testing.assert_array_equal(M[..., c][simulated], whole[simulated])
        assert np.abs(whole[~simulated]).max() <= OF_NOISE.forgotten_share_of_cycle_effect * np.abs(whole).max()
        assert simulated.sum() < 5 * cycles.sum(axis=0).max()


def test_a_simulation_that_runs_away_has_no_directions_and_breaks_nothing():
    equations = joint_equations(0)
    simulator = Factory()(equations)
    theta = np.array([VALUES[q.id] for q in equations.parameters])
    theta[[q.id for q in equations.parameters].index("Ks")] = -1e6
    t = np.arange(0.0, 8.0, 0.01)
    run = run_with(0.008 * np.cos(OMEGA * t), np.zeros_like(t), t)
    x0 = np.array([1.0, 0.0, 0.0])

    about, S = relinearise_cycles(simulator, run, NOISE, theta, x0)
    assert about is run
    assert not np.isfinite(S).all()
    assert Whitener.of(Arma(), S) == Whitener()
    assert best_scatter([np.zeros(t.size)], [np.zeros((t.size, 0))], [S[:, 0]]) == (0.0, 0.0)


def test_a_wrong_model_moves_no_cycle_beyond_where_its_torque_is_believable():
    equations = joint_equations(0)
    simulator, theta = Factory()(equations), np.array([VALUES[q.id] for q in equations.parameters])
    t = np.arange(0.0, 8.0, 0.01)
    run = run_with(0.008 * np.cos(OMEGA * t), np.full_like(t, 50.0), t)
    x0 = initial_state(equations, run.but(y=np.zeros((t.size, 1))))
    about, S = relinearise_cycles(simulator, run, Noise(scatters=(SCATTER.but(size=0.5),)), theta, x0)
    assert np.isfinite(S).all()
    moved = np.abs(about.u[:, 0]) > np.abs(run.u[:, 0]) * np.exp(THRESHOLDS.fit.largest_log_torque_factor) * (1 + 1e-9)
    assert not moved.any()


def test_amplitudes_of_cycles_that_nothing_tells_apart_are_shared():
    S = np.full((50, 2), 1e9)
    assert most_probable(S, np.full(50, 1e9)) == pytest.approx([0.5, 0.5], rel=1e-6)


def test_directions_are_those_of_the_singular_value_decomposition_where_columns_repeat():
    rng = np.random.default_rng(5)
    M = rng.standard_normal((400, 6)) * np.array([1e3, 300.0, 30.0, 3.0, 1.0, 0.1])
    M = np.column_stack((M, M[:, :2]))
    U, d = directions(M)
    exact = np.linalg.svd(M)[1][:6]
    np.testing.assert_allclose(np.sort(d)[::-1], exact, rtol=1e-6)
    np.testing.assert_allclose(U.T @ U, np.eye(6), atol=1e-6)


def test_of_two_joints_each_has_cycles_and_amplitudes_of_its_own(tmp_path: Path):
    sensor = Sensor(noise=1e-4, resolution=0.0)
    runs = [coupled_test(Arm(read_truth()), number, sensor=sensor, seed=(7, number)) for number in (0, 3)]
    write_campaign(tmp_path, header("coupled", "freedom6s", sensor), runs, joints=6)
    study = coupled_study_of(prepare(read_campaign(tmp_path)), (0, 1), catalogue(), {})
    simulator, run = study.simulator(), study.fitted[0]
    assert not [key for key in study.in_si({q.id: q.initial for q in study.base.parameters}) if "scatter" in key]
    theta, x0 = np.array([q.initial for q in study.base.parameters]), initial_state(study.base, run)
    on_torque, on_reading = Scatter(size=0.03, path="torque"), Scatter(size=0.02, path="reading", centre=0.05, column=1)
    first, second = (cycles_of(run, scatter) for scatter in (on_torque, on_reading))
    assert first.count != second.count
    rng = np.random.default_rng(4)
    b = 0.03 * rng.standard_normal(first.count)
    u = run.u.copy()
    u[:, 0] *= np.exp(b[first.index])
    y = simulator.simulate(theta, run.but(u=u), x0=x0).y[:, :2]
    y[:, 1] = 0.05 + (y[:, 1] - 0.05) * (1.0 + 0.02 * rng.standard_normal(second.count)[second.index])
    read = run.but(y=y + run.sensor_std * rng.standard_normal(y.shape))

    about, S = relinearise_cycles(simulator, read, Noise(scatters=(on_torque, on_reading)), theta, x0)
    assert S.shape == (*run.y.shape, first.count + second.count)
    assert np.array_equal(about.u[:, 1], run.u[:, 1])
    found = np.log(np.array([about.u[first.index == k, 0][0] / run.u[first.index == k, 0][0] for k in range(len(b))]))
    assert found == pytest.approx(b, abs=3e-3)
    moved = np.abs(S).max(axis=0)
    assert (moved[1, : first.count] > 0.1).all()  # the torque of one joint moves the other as well
    assert not moved[0, first.count :].any()
    r = (about.y - simulator.simulate(theta, about, x0=x0).y[:, :2]) / run.sensor_std
    white = Whitener.of(Arma(), S)(r)
    assert np.mean(white**2) < 1.1


def test_a_whitener_of_several_joints_is_the_root_of_their_inverse_covariance():
    rng = np.random.default_rng(6)
    S, x = rng.standard_normal((40, 2, 5)), rng.standard_normal((40, 2, 3))
    whiten = Whitener.of(Arma(), S)
    C = np.eye(80) + S.reshape(80, 5) @ S.reshape(80, 5).T
    white, flat = whiten(x).reshape(80, 3), x.reshape(80, 3)
    np.testing.assert_allclose(white.T @ white, flat.T @ np.linalg.solve(C, flat), rtol=1e-9)
    assert whiten.log_determinant(80) == pytest.approx(np.linalg.slogdet(C)[1])
    np.testing.assert_allclose(whiten(x[:, :, 0]), whiten(x)[:, :, 0], rtol=1e-12)


@pytest.mark.parametrize("size", [3e-2, 2e-4])
def test_degrees_of_freedom_are_those_of_the_spread_of_its_estimates(size: float) -> None:
    """Clear of the noise a run of K cycles has K − 2 and ln s scatters by 1/√(2K); near it fewer and by more."""
    t = np.arange(0.0, 16.0 * np.pi, 0.01)
    run = run_with(np.cos(OMEGA * t), np.zeros_like(t), t)
    cycles = whole_cycles(run)
    M = np.sin(OMEGA * t)[:, None] * cycles.inside / 1e-3
    scatter = SCATTER.but(size=size)
    freedom = degrees_of_freedom([run], [Whitener.of(Arma(), size * M[:, None])], [scatter], scatter)
    share = freedom / (cycles.count - 2)
    assert share == pytest.approx(1.0, abs=1e-3) if size > 1e-3 else 0.6 < share < 0.8

    rng, found = np.random.default_rng(4), []
    for _ in range(200):
        r = M @ (size * rng.standard_normal(cycles.count)) + rng.standard_normal(t.size)
        found.append(best_scatter([r], [np.zeros((t.size, 0))], [M])[0])
    assert np.std(np.log(found)) == pytest.approx(1 / np.sqrt(2 * share * 16), rel=0.25)


def test_restricted_likelihood_by_runs_is_that_of_all_rows() -> None:
    """Against the dense covariance of what is left once the parameters are out, s at its maximum and the gain there."""
    rng = np.random.default_rng(8)
    M = [rng.standard_normal((60, 5)), rng.standard_normal((80, 7))]
    Q = np.linalg.qr(np.column_stack((rng.standard_normal((140, 3)), block_diag(*M)[:, [0, 7]])))[0]
    P = null_space(Q.T)
    r = block_diag(*M) @ (0.3 * rng.standard_normal(12)) + rng.standard_normal(140)
    r -= Q @ (Q.T @ r)

    def deviance(s: float) -> float:
        C = np.eye(P.shape[1]) + s**2 * P.T @ block_diag(*M) @ block_diag(*M).T @ P
        return float(np.linalg.slogdet(C)[1] + (P.T @ r) @ np.linalg.solve(C, P.T @ r))

    s, gain = best_scatter(np.split(r, [60]), np.split(Q, [60]), M)
    assert gain == pytest.approx(deviance(0.0) - deviance(s), rel=1e-9)
    assert gain > 5.0
    assert deviance(s) <= min(deviance(1.02 * s), deviance(0.98 * s))
