"""The inner step along the homotopy: chosen by halving, the same through an FMU, and gone from the result."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from haptid.fmu_build.building.cached import identification_fmu
from haptid.identification.optimise import inner_step
from haptid.identification.optimise.homotopy import descend
from haptid.identification.optimise.inner_step import at_inner_step, coarsen, finer_step, steps_of
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.observer import Observed
from haptid.identification.thresholds import THRESHOLDS as IDENTIFICATION
from haptid.model.thresholds import THRESHOLDS
from haptid.support.linear_algebra import inverse, orthonormal_basis, profile_out, sandwich
from tests.identification.bench_joint import TRUE, equations, runs


@pytest.fixture(scope="module")
def problem() -> Problem:
    fitted = tuple(run for run in runs() if run.use == "fit")
    return Problem.of(KernelSimulator.of(equations()), fitted, FitOptions())


def test_steps_go_from_one_per_row_to_the_models_own(problem):
    steps = steps_of(problem)
    rows = float(np.median(np.diff(problem.runs[0].t)))
    assert steps[-1] == THRESHOLDS.inner_step_s
    assert rows <= steps[0] < 2.0 * rows
    assert all(np.isclose(a, 2.0 * b) for a, b in pairwise(steps))


@pytest.mark.parametrize("kind", ["native", "python"])
def test_fmu_takes_the_step_of_the_kernel(problem, kind):
    kernel, run = problem.simulator, problem.runs[0]
    fmu = FmuSimulator.of(identification_fmu(kernel.equations, kind=kind), kernel.equations)
    theta = problem.theta(problem.unknowns_at(problem.parametrisation.initial))
    own = kernel.simulate(theta, run, sensitivities=True)
    for step in (THRESHOLDS.inner_step_s, 2.5e-3, 1.0):
        here = kernel.with_step(step).simulate(theta, run, gain=6.0, sensitivities=True)
        there = fmu.with_step(step).simulate(theta, run, gain=6.0, sensitivities=True)
        np.testing.assert_allclose(there.y, here.y, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(there.dy_dtheta, here.dy_dtheta, rtol=1e-6, atol=1e-9)
    assert np.abs(kernel.with_step(1.0).simulate(theta, run).y - own.y).max() > 0.0


def test_observed_passes_the_step_on(problem):
    seen = Observed(problem.simulator, 5.0).with_step(2.5e-3)
    assert seen.base.step == 2.5e-3
    assert seen.least == 5.0


def test_stiff_friction_gets_a_finer_step(problem):
    x = problem.unknowns_at(problem.parametrisation.initial)
    calm = coarsen(problem, x, 20.0).simulator.step
    run = problem.runs[0]
    rough = problem.options.but(gains=(0.0,))
    # At the noise the residual is small, so that less error is let in than far from the data.
    theta = np.array([TRUE.get(q.id, q.initial) for q in problem.simulator.equations.parameters])
    clean = run.but(y=problem.simulator.simulate(theta, run).y)
    exact = Problem.of(problem.simulator, (clean,), rough)
    assert coarsen(exact, exact.unknowns_at(theta), 0.0).simulator.step == THRESHOLDS.inner_step_s < calm


def test_a_coarser_step_is_near_the_models_own_and_not_only_near_its_half(problem, monkeypatch):
    # Errors that grow by little from half to half, as those of stiff bristles do, and are large at the coarsest.
    def residual(_problem, step, _x, _gain):
        return np.array([1.0, 0.08 * np.log2(step / THRESHOLDS.inner_step_s)])

    monkeypatch.setattr(inner_step, "_residual", residual)
    x = problem.unknowns_at(problem.parametrisation.initial)
    assert coarsen(problem, x, 0.0).simulator.step == 2.0 * THRESHOLDS.inner_step_s


@pytest.mark.parametrize("finer", [True, False])
def test_a_result_has_a_finer_step_where_that_of_the_model_shows_beside_the_noise(problem, finer):
    simulator, run = problem.simulator, problem.runs[0]
    theta = np.array([TRUE.get(q.id, q.initial) for q in simulator.equations.parameters])
    exact = simulator.with_step(THRESHOLDS.inner_step_s / 64).simulate(theta, run).y
    error = float(np.sqrt(np.mean((simulator.simulate(theta, run).y - exact) ** 2)))
    # The noise of a sensor that is as good as the step's error, and of one that hides it.
    std = 0.3 * error if finer else 1e3 * error
    noisy = exact + std * np.random.default_rng(1).standard_normal(exact.shape)
    seen = Problem.of(simulator, (run.but(y=noisy, noise=np.array([std]), resolution=np.zeros(1)),), problem.options)
    step = finer_step(seen, seen.unknowns_at(theta))
    assert (step < THRESHOLDS.inner_step_s) == finer
    left = at_inner_step(seen, step).blocks(seen.unknowns_at(theta)).residual
    assert np.mean(left**2) < 1.1


def test_an_error_that_hides_in_every_row_and_moves_the_estimates_gets_a_finer_step(problem):
    """An inertia was ten standard deviations off: of many rows a tenth of the residual's norm is that much."""
    simulator, run = problem.simulator, problem.runs[0]
    theta = np.array([TRUE.get(q.id, q.initial) for q in simulator.equations.parameters])
    exact = simulator.with_step(THRESHOLDS.inner_step_s / 64).simulate(theta, run).y
    std = 15.0 * float(np.sqrt(np.mean((simulator.simulate(theta, run).y - exact) ** 2)))
    noisy = exact + std * np.random.default_rng(1).standard_normal(exact.shape)
    seen = Problem.of(simulator, (run.but(y=noisy, noise=np.array([std]), resolution=np.zeros(1)),), problem.options)
    x = seen.unknowns_at(theta)

    def error(step: float) -> np.ndarray:
        exactly = at_inner_step(seen, THRESHOLDS.inner_step_s / 64).blocks(x, jacobian=False).residual
        return at_inner_step(seen, step).blocks(x, jacobian=False).residual - exactly

    basis = orthonormal_basis(seen.blocks(x).jacobian)
    own = error(THRESHOLDS.inner_step_s)
    assert np.linalg.norm(own) < IDENTIFICATION.largest_inner_step_error_over_residual * np.sqrt(own.size)
    assert np.linalg.norm(basis.T @ own) > 2.0 * IDENTIFICATION.largest_shift_by_inner_step
    step = finer_step(seen, x)
    assert step < THRESHOLDS.inner_step_s
    assert np.linalg.norm(basis.T @ error(step)) < 0.5 * np.linalg.norm(basis.T @ own)


def test_minimum_is_that_of_the_models_own_step(problem):
    x = problem.unknowns_at(problem.parametrisation.initial)
    found = descend(problem, x)
    coarse = at_inner_step(problem, steps_of(problem)[0])
    blocks = problem.blocks(found.x)
    gradient = blocks.jacobian.T @ blocks.residual
    step = np.linalg.solve(blocks.jacobian.T @ blocks.jacobian, gradient)
    assert float(step @ gradient) < 1e-6 * found.cost
    assert found.cost == pytest.approx(float(blocks.residual @ blocks.residual), rel=1e-12)
    assert coarse.blocks(found.x).residual @ coarse.blocks(found.x).residual != found.cost


def test_matrices_stay_positive_where_rounding_rules():
    rng = np.random.default_rng(3)
    J = rng.standard_normal((40, 5)) * np.array([1.0, 1e6, 1e-6, 1.0, 1.0])
    H = J.T @ J
    np.testing.assert_allclose(inverse(H), np.linalg.inv(H), rtol=1e-6)
    whole = np.linalg.inv(np.linalg.inv(H)[:3, :3])
    np.testing.assert_allclose(profile_out(H, range(3)), whole, rtol=1e-6)
    meat = J.T @ np.diag(rng.uniform(0.5, 2.0, 40)) @ J
    np.testing.assert_allclose(sandwich(H, meat), np.linalg.inv(H) @ meat @ np.linalg.inv(H), rtol=1e-6)
    J[:, 4] = J[:, 3] * (1 + 1e-12)
    for matrix in (inverse(J.T @ J), sandwich(J.T @ J, meat), profile_out(J.T @ J, range(4))):
        assert np.all(np.diag(matrix) >= 0)
        assert np.all(np.isfinite(matrix))
