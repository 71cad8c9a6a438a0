"""Least squares with inequalities, Levenberg–Marquardt, SLSQP, homotopy."""

from __future__ import annotations

from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from haptid.identification.optimise import homotopy
from haptid.identification.optimise.homotopy import descend, feasible, is_near_the_data
from haptid.identification.optimise.levenberg_marquardt import SumOfSquares, cost_of, minimise
from haptid.identification.optimise.slsqp import slsqp
from haptid.identification.problem.bounded_lsq import step_within, triangle
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.passivity import margin
from haptid.identification.problem.residuals import Problem
from haptid.identification.thresholds import THRESHOLDS
from tests.identification.bench_joint import TRUE, equations, runs, simulator


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_bounded_step_agrees_with_scipy(seed):
    rng = np.random.default_rng(seed)
    J, r = rng.standard_normal((30, 5)), rng.standard_normal(30)
    lower, upper = -rng.uniform(0.0, 0.2, 5), rng.uniform(0.0, 0.2, 5)
    A, slack = np.vstack((np.eye(5), -np.eye(5))), np.concatenate((lower, -upper))
    d = step_within(*triangle(J, r), A, slack)
    np.testing.assert_allclose(d, lsq_linear(J, -r, bounds=(lower, upper), method="bvls").x, atol=1e-7)


def test_general_inequalities_agree_with_a_convex_solver():
    rng = np.random.default_rng(3)
    J, r = rng.standard_normal((20, 4)), rng.standard_normal(20)
    A, slack = rng.standard_normal((6, 4)), -rng.uniform(0.0, 0.05, 6)
    x = cp.Variable(4)
    cp.Problem(cp.Minimize(cp.sum_squares(J @ x + r)), [A @ x >= slack]).solve(solver=cp.CLARABEL)
    np.testing.assert_allclose(step_within(*triangle(J, r), A, slack), x.value, atol=1e-6)


def problem(**options) -> Problem:
    return Problem.of(simulator(), tuple(run for run in runs() if run.use == "fit"), FitOptions(**options))


def guess(p: Problem):
    return p.unknowns_at(np.array([q.initial for q in equations().parameters]))


def errors(p: Problem, x):
    found = dict(zip((q.id for q in equations().parameters), p.theta(x), strict=True))
    return {id: found[id] / value - 1.0 for id, value in TRUE.items()}


@pytest.mark.parametrize("method", ["slsqp", "gauss_newton"])
def test_homotopy_reaches_truth_and_noise(method):
    p = problem(method=method)
    found = descend(p, guess(p))
    assert np.sqrt(found.cost / p.weight) < 1.05
    assert found.converged
    assert abs(errors(p, found.x)["sigma0"]) < 0.05
    assert abs(errors(p, found.x)["sigma2"]) < 0.01


def test_methods_agree_on_the_minimum():
    p = problem()
    x = guess(p)
    x[: p.n_parameters] = p.parametrisation.to_coordinates(
        np.array([TRUE.get(q.id, q.initial) for q in equations().parameters])
    )
    a = minimise(SumOfSquares.of(p), x, iterations=60, tolerance=0.0, relative=1e-10)
    b = slsqp(p, x, iterations=120, tolerance=1e-10)
    assert b.cost == pytest.approx(a.cost, rel=1e-5)
    # At the minimum the gradient vanishes: no first-order change of the cost is left in any direction.
    blocks = p.blocks(a.x)
    slope = blocks.jacobian.T @ blocks.residual / np.linalg.norm(blocks.jacobian, axis=0)
    assert np.abs(slope).max() < 1e-2


def test_levels_that_are_left_out_change_no_minimum(monkeypatch):
    p = problem()
    short = descend(p, guess(p))
    monkeypatch.setattr(homotopy, "is_near_the_data", lambda *_: False)
    whole = descend(p, guess(p))
    assert short.calls < 0.85 * whole.calls
    assert short.cost == pytest.approx(whole.cost, rel=1e-7)
    n = p.n_parameters
    J = p.blocks(whole.x).jacobian[:, :n]
    # In standard deviations of what the data know: a hundredth of one at most.
    assert np.linalg.norm(J @ (short.x - whole.x)[:n]) < 0.01


def test_a_joint_at_rest_is_not_near_data_of_a_noisy_sensor():
    quiet = problem()
    at_minimum = descend(quiet, guess(quiet)).x
    assert is_near_the_data(quiet, at_minimum)
    assert not is_near_the_data(quiet, guess(quiet))
    # Five times less motion than noise: three standard deviations hold anything.
    loud = replace(quiet, runs=tuple(run.but(noise=5.0 * np.std(run.y, axis=0)) for run in quiet.runs))
    far = guess(loud)
    assert np.sqrt(cost_of(loud.blocks(far)) / loud.weight) < THRESHOLDS.largest_residual_near_the_data
    assert not is_near_the_data(loud, far)


def test_bounds_and_ordering_hold():
    eq = equations().with_parameters({"Fs": {"upper": TRUE["Fc"] * 0.9, "initial": TRUE["Fc"] * 0.8}})
    sim = type(simulator())(eq, simulator().kernel)
    p = Problem.of(sim, tuple(run for run in runs() if run.use == "fit"), FitOptions(gains=(20.0, 0.0)))
    found = descend(p, p.unknowns_at(np.array([q.initial for q in eq.parameters])))
    theta = dict(zip((q.id for q in eq.parameters), p.theta(found.x), strict=True))
    assert theta["Fs"] <= TRUE["Fc"] * 0.9 * (1 + 1e-9)
    assert theta["Fs"] >= theta["Fc"] * (1 - 1e-9)


def test_feasible_moves_inside():
    p = problem()
    x = guess(p)
    x[: p.n_parameters] = 50.0
    A, b = p.constraints()
    assert np.all(A @ feasible(p, x) >= b - 1e-9)


def test_passivity_holds_on_request():
    place = [q.id for q in equations().parameters].index
    p = problem(passive=True, gains=(20.0, 0.0))
    theta = p.theta(descend(p, guess(p)).x)
    value, gradient = margin(equations(), theta)
    assert value[0] >= -1e-6
    assert theta[place("sigma2")] >= theta[place("sigma1")] * (theta[place("Fs")] / theta[place("Fc")] - 1) * 0.99
    for k in range(theta.size):
        step = np.zeros_like(theta)
        step[k] = 1e-6 * theta[k] if theta[k] else 1e-9
        difference = (margin(equations(), theta + step)[0] - margin(equations(), theta - step)[0]) / (2 * step[k])
        np.testing.assert_allclose(gradient[:, k], difference, rtol=1e-4, atol=1e-6)


def test_simulation_that_leaves_the_finite_numbers_ends_quietly():
    class Broken:
        equations = simulator().equations

        def simulate(self, theta, run, **choices):
            made = simulator().simulate(theta, run, **choices)
            made.y[:] = np.nan
            return made

    p = Problem.of(Broken(), problem().runs, FitOptions(gains=(0.0,)))
    assert descend(p, guess(p)).cost == np.inf
