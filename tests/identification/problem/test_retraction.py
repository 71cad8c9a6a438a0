"""Steps along the valley of a spring and its equilibrium position."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.retraction import Retraction
from tests.identification.bench_joint import equations, runs, simulator


@pytest.fixture(scope="module")
def retraction() -> Retraction:
    return Retraction.of(Problem.of(simulator(), runs()[:1], FitOptions()))


def start(retraction):
    problem = retraction.problem
    x = problem.unknowns_at(np.array([q.initial for q in equations().parameters]))
    x[problem.parametrisation.ids.index("epos")] = 0.4
    return x


def offset(retraction, x):
    theta = dict(zip((q.id for q in equations().parameters), retraction.problem.theta(x), strict=True))
    return theta["Ks"] * theta["epos"]


def test_offset_torque_moves_linearly(retraction):
    x = start(retraction)
    d = np.zeros(x.size)
    for id, step in (("Ks", 0.3), ("epos", -0.2)):
        d[retraction.problem.parametrisation.ids.index(id)] = step
    moves = [offset(retraction, retraction.move(x, share * d)) for share in (0.0, 0.5, 1.0)]
    assert moves[1] - moves[0] == pytest.approx(moves[2] - moves[1], rel=1e-9)
    assert moves[1] != pytest.approx(moves[0], rel=1e-3)


def test_slope_is_the_derivative_of_the_move(retraction):
    x, rng = start(retraction), np.random.default_rng(0)
    d = 0.1 * rng.standard_normal(x.size)
    slope = retraction.slope(x, d)
    for k in range(x.size):
        h = 1e-6 * np.eye(x.size)[k]
        difference = (retraction.move(x, d + h) - retraction.move(x, d - h)) / 2e-6
        np.testing.assert_allclose(slope[:, k], difference, atol=1e-7)


def test_no_allowed_step_leaves_the_bounds(retraction):
    x, rng = start(retraction), np.random.default_rng(1)
    A, slack = retraction.constraints(x)
    lower, upper = retraction.problem.parametrisation.bounds
    allowed = 0
    for _ in range(400):
        d = rng.standard_normal(x.size) * rng.uniform(0, 3)
        inside = bool(np.all(A @ d >= slack))
        y = retraction.move(x, d)[: lower.size]
        order, limit = retraction.problem.parametrisation.orderings()
        obeys = bool(np.all(y >= lower - 1e-9) and np.all(y <= upper + 1e-9) and np.all(order @ y >= limit - 1e-9))
        assert obeys or not inside
        allowed += inside
    assert allowed > 20
