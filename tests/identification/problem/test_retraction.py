"""Steps along the valleys of a spring and of bristles that are bent at the start."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.problem.retraction import Retraction
from haptid.measurement.values.run import Array
from tests.discrepancy.torque.test_torque import sweep
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


@pytest.fixture(scope="module")
def along_motion() -> Retraction:
    """Friction along a measured motion, whose bristles may be bent at the start."""
    study = sweep(0.001)
    return Retraction.of(Problem.of(study.simulator(), study.runs, FitOptions()))


def first(retraction: Retraction) -> Array:
    """Return the unknowns at the first guesses."""
    problem = retraction.problem
    return problem.unknowns_at(np.array([q.initial for q in problem.simulator.equations.parameters]))


def bent(retraction: Retraction, x: Array, torque: float) -> Array:
    """Return unknowns at which the bristles push with a torque [N m] at the start."""
    problem = retraction.problem
    ((start,),) = (some.start for some in retraction.bristles)  # one run, one bristle
    stiffness = np.exp(x[problem.parametrisation.ids.index("sigma0")])
    y = x.copy()
    y[start] = torque / stiffness / problem.starts[0].unit[0]
    return y


def pushed(retraction: Retraction, x: Array) -> float:
    """Return the torque σ₀·z₀ of the bristles at the start [N m]."""
    problem = retraction.problem
    theta = dict(zip((q.id for q in problem.simulator.equations.parameters), problem.theta(x), strict=True))
    return float(theta["sigma0"] * problem.x0(x)[0][0])


def test_bristles_keep_their_torque_at_the_start_as_they_get_stiffer(along_motion):
    x = bent(along_motion, first(along_motion), 0.02)
    (some,) = along_motion.bristles
    d = np.zeros(x.size)
    d[some.stiffness], d[list(some.start)] = 7.0, -7.0 * x[list(some.start)]
    assert pushed(along_motion, x) == pytest.approx(0.02)
    assert pushed(along_motion, along_motion.move(x, d)) == pytest.approx(0.02)
    # A straight step would leave a torque of the other sign, a thousand times as large.
    assert abs(pushed(along_motion, x + d)) > 100.0


def test_slope_is_the_derivative_of_the_move_of_bristles(along_motion):
    rng = np.random.default_rng(2)
    x = bent(along_motion, first(along_motion), 0.02)
    d = 0.1 * rng.standard_normal(x.size)
    slope = along_motion.slope(x, d)
    for k in range(x.size):
        h = 1e-6 * np.eye(x.size)[k]
        difference = (along_motion.move(x, d + h) - along_motion.move(x, d - h)) / 2e-6
        np.testing.assert_allclose(slope[:, k], difference, atol=1e-7)
