"""Readings at the fine step with sensitivities of the coarse one; kernels found again on disk."""

import numpy as np
import pytest

from haptid.discrepancy.study.simulators import Factory, compile_kernel
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import initial_state
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel import cache as kernel_cache
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel

VALUES = {
    "inertia": 1.6e-4, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.018, "epos": 0.03, "sigma0": 0.5,
    "sigma1": 0.003, "sigma2": 1.3e-3, "vs": 0.06, "Fs": 1.5e-3, "Fc": 1.1e-3, "k3": 0.01,
}  # fmt: skip


@pytest.fixture(scope="module")
def equations():
    return joint_equations(0, effects=[catalogue()["cubic_spring"]])


@pytest.fixture(scope="module")
def run() -> Run:
    t = np.arange(0.0, 4.0, 0.01)
    return Run(
        file="cosine", free_joints=(0,), t=t, u=0.008 * np.cos(2.0 * t)[:, None], y=np.zeros((t.size, 1)),
        noise=np.array([2e-4]),
        resolution=np.zeros(1), posture=np.zeros(1), use="fit",
    )  # fmt: skip


def test_readings_are_those_of_the_fine_step_and_slopes_those_of_the_coarse(equations, run):
    theta = np.array([VALUES[q.id] for q in equations.parameters])
    fine, coarse = (
        Factory(THRESHOLDS.study.coarse_step_s / 8)(equations),
        Factory(THRESHOLDS.study.coarse_step_s)(equations),
    )
    both = fine.simulate(theta, run, sensitivities=True)
    assert both.y == pytest.approx(fine.simulate(theta, run).y, abs=0)
    assert both.dy_dtheta == pytest.approx(coarse.simulate(theta, run, sensitivities=True).dy_dtheta, abs=0)
    place = [q.id for q in equations.parameters].index("Ks")
    moved = theta.copy()
    moved[place] *= 1 + 1e-5
    slope = (fine.simulate(moved, run).y - both.y)[:, 0] / (moved - theta)[place]
    assert both.dy_dtheta[:, 0, place] == pytest.approx(slope, abs=2e-2 * np.abs(slope).max())


def test_a_kernel_is_found_again_on_disk(equations, run, monkeypatch):
    first = cached_kernel(equations, many=False)

    def never(*_, **__):
        raise AssertionError("generated again")

    monkeypatch.setattr(kernel_cache.CompiledKernel, "of", never)
    again = cached_kernel(equations, many=False)
    assert isinstance(again, CompiledKernel)
    assert again.path == first.path
    assert again.kernel.columns == first.kernel.columns
    theta = [VALUES[q.id] for q in equations.parameters]
    x0 = initial_state(equations, run)
    y, dy = again.simulate_tangent(run.t, run.u, theta, x0)
    assert np.isfinite(y).all()
    assert dy.shape == (run.t.size, 1, len(first.kernel.columns))


def test_sensitivities_are_taken_by_the_initial_values_that_are_fitted_alone(run):
    equations = joint_equations(0, friction="maxwell_slip")
    theta = np.array([q.initial for q in equations.parameters])
    whole = KernelSimulator.of(equations).simulate(theta, run, sensitivities=True)
    made = KernelSimulator(equations, compile_kernel(equations)).simulate(theta, run, sensitivities=True)
    assert equations.starts == (0, 1)
    assert len(compile_kernel(equations).kernel.columns) == theta.size + 2
    np.testing.assert_array_equal(made.y, whole.y)
    np.testing.assert_array_equal(made.dy_dtheta, whole.dy_dtheta)
    np.testing.assert_array_equal(made.dy_dx0[..., :2], whole.dy_dx0[..., :2])
    assert np.isnan(made.dy_dx0[..., 2:]).all()
    assert np.abs(whole.dy_dx0[..., 2:]).max() > 0.0


def test_joints_with_the_same_formulas_share_a_kernel(monkeypatch):
    one, other = joint_equations(2), joint_equations(3)
    assert one.digest != other.digest
    first = cached_kernel(one, many=False)

    def never(*_, **__):
        raise AssertionError("generated again")

    monkeypatch.setattr(kernel_cache.CompiledKernel, "of", never)
    again = cached_kernel(other, many=False)
    assert again.path == first.path
    assert again.equations.name == "joint3"
