"""Scaled unknowns, residuals and their Jacobian."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptid.identification.problem.loss import pseudo_huber
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.weights import time_weights
from haptid.model.equations.quantity import Normal
from haptid.support.errors import InputError
from tests.identification.bench_joint import TRUE, equations, runs, simulator


def problem(**options) -> Problem:
    fitted = tuple(run for run in runs() if run.use == "fit")
    return Problem.of(simulator(), fitted, FitOptions(**options))


def true_x(p: Problem):
    theta = np.array([TRUE.get(q.id, q.initial) for q in equations().parameters])
    return p.unknowns_at(theta)


@settings(deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=9, max_size=9))
def test_coordinates_go_there_and_back(shift):
    parametrisation = Parametrisation.of(equations())
    s = np.clip(parametrisation.to_coordinates(parametrisation.initial) + np.array(shift), *parametrisation.bounds)
    np.testing.assert_allclose(parametrisation.to_coordinates(parametrisation.physical(s)), s, atol=1e-12)


def test_fixed_parameters_keep_their_value():
    parametrisation = Parametrisation.of(equations())
    assert "Kp" not in parametrisation.ids
    assert (
        parametrisation.physical(np.zeros(len(parametrisation.free)))[
            [q.id for q in equations().parameters].index("Kp")
        ]
        == 1.0
    )


def test_rounding_takes_no_parameter_beyond_its_bounds():
    parametrisation = Parametrisation.of(equations())
    k = parametrisation.ids.index("Ks")
    s = np.zeros(len(parametrisation.free))
    s[k] = parametrisation.bounds[0][k] * (1 + 1e-12) - 1e-12
    theta = parametrisation.physical(s)
    for quantity, value in zip(equations().parameters, theta, strict=True):
        assert quantity.fixed or quantity.lower <= value <= quantity.upper


def test_ordering_is_stiction_above_coulomb():
    parametrisation = Parametrisation.of(equations())
    A, b = parametrisation.orderings()
    s = parametrisation.to_coordinates(parametrisation.initial)
    theta = parametrisation.initial
    place = [q.id for q in equations().parameters].index
    assert (A @ s - b)[0] == pytest.approx(np.log(theta[place("Fs")] / theta[place("Fc")]))


@pytest.mark.parametrize("every_positive_in_log", [False, True])
def test_many_sets_are_converted_at_once_and_the_slope_is_the_derivative(every_positive_in_log):
    p = Parametrisation.of(equations(), every_positive_in_log=every_positive_in_log)
    s = p.to_coordinates(p.initial) + 0.01 * np.random.default_rng(0).standard_normal((2, 3, len(p.free)))
    theta = p.physical(s)
    assert theta.shape == (2, 3, p.initial.size)
    np.testing.assert_array_equal(theta[1, 2], p.physical(s[1, 2]))
    np.testing.assert_allclose(p.to_coordinates(theta), s, atol=1e-12)
    difference = (p.values(s + 1e-6) - p.values(s - 1e-6)) / 2e-6
    np.testing.assert_allclose(p.slope(theta), difference, rtol=1e-6)
    np.testing.assert_allclose(p.log_slope(s), np.log(difference), atol=1e-6)


def test_the_sampler_takes_every_positive_parameter_in_its_logarithm_also_from_zero():
    from_zero = equations().with_parameters({"Ks": {"lower": 0.0}})
    p = Parametrisation.of(from_zero, every_positive_in_log=True)
    k = p.ids.index("Ks")
    assert not Parametrisation.of(from_zero).log[k]
    assert p.log[k]
    assert np.isfinite(p.bounds[0][k])


def test_sets_that_violate_an_ordering_are_told():
    p = Parametrisation.of(equations())
    place = [q.id for q in equations().parameters].index
    sets = np.tile(p.initial, (2, 1))
    sets[1, place("Fc")] = 1.1 * sets[1, place("Fs")]
    assert p.meets_orderings(sets).tolist() == [True, False]


@pytest.mark.parametrize("gain", [0.0, 20.0])
@pytest.mark.parametrize("robust", [False, True])
def test_jacobian_is_the_derivative_of_the_residual(gain, robust):
    p = problem(robust=robust, free_velocity=True)
    x = true_x(p)
    x[p.n_parameters :] = 0.3
    J = p.blocks(x, gain).jacobian
    for k in range(p.size):
        step = 1e-5 * np.eye(p.size)[k]
        difference = p.blocks(x + step, gain).residual - p.blocks(x - step, gain).residual
        # Differences across a reversal, where friction has a kink, are themselves a little off.
        assert np.linalg.norm(J[:, k] - difference / 2e-5) < 0.02 * np.linalg.norm(J[:, k])


def test_truth_leaves_the_noise():
    p = problem()
    r = p.blocks(true_x(p), jacobian=False).residual
    assert np.sqrt(r @ r / p.weight) == pytest.approx(1.0, abs=0.04)


def test_prior_adds_one_residual():
    eq = equations().with_parameters({"Ks": {"prior": Normal(mean=0.01, std=0.002)}})
    fitted = tuple(run for run in runs() if run.use == "fit")
    sim = type(simulator())(eq, simulator().kernel)
    p = Problem.of(sim, fitted, FitOptions())
    blocks = p.blocks(true_x(p))
    assert blocks.prior[0] == pytest.approx((TRUE["Ks"] - 0.01) / 0.002)
    without = Problem.of(sim, fitted, FitOptions(priors=False)).blocks(true_x(p))
    assert without.prior.size == blocks.prior.size - 1


def test_weights_are_those_of_the_paper():
    run = runs()[0]
    weights = time_weights(run)
    assert weights[0] == 1.0
    assert set(weights[1:600]) == {0.5}
    assert set(weights[601:]) == {1.0}
    held_out = time_weights(run.but(score_from=800))
    assert held_out[0] == 1.0
    assert not held_out[1:800].any()


def test_noise_must_be_known():
    run = runs()[0].but(noise=np.array([0.0]))
    with pytest.raises(InputError, match="sensor noise"):
        Problem.of(simulator(), (run,), FitOptions())


def test_pseudo_huber_is_square_inside_and_linear_outside():
    r = np.array([1e-9, -0.01, 0.01, 300.0, -3000.0])
    w, slope = pseudo_huber(r)
    np.testing.assert_allclose(w[:3], r[:3], rtol=1e-5)
    assert w[3] ** 2 == pytest.approx(2 * 3.0 * 300.0, rel=0.02)
    step = 1e-6
    np.testing.assert_allclose(slope[1:], ((pseudo_huber(r + step)[0] - w) / step)[1:], rtol=1e-3)


def test_run_in_motion_frees_its_velocity():
    run = runs()[0]
    fastest = int(np.argmax(np.abs(np.gradient(run.y[:, 0]))))
    moving = run.but(t=run.t[fastest:] - run.t[fastest], y=run.y[fastest:], u=run.u[fastest:])
    still, fast = Problem.of(simulator(), (run,), FitOptions()), Problem.of(simulator(), (moving,), FitOptions())
    assert fast.starts[0].states == (0, 1)
    slope = np.gradient(run.y[:, 0], run.t)[fastest]
    assert fast.starts[0].unit[1] == pytest.approx(abs(slope), rel=0.5)
    assert still.starts[0].unit[-1] < 0.5 * fast.starts[0].unit[1]
