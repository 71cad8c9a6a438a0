"""QR run after run against one QR of everything; valleys are walked to their end unless far more than noise is left."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.identification.optimise.levenberg_marquardt import SumOfSquares, minimise, triangle_by_runs
from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.problem.residuals import Blocks
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def test_runs_apart_give_the_same_normal_equations_as_all_at_once():
    rng = np.random.default_rng(3)
    rows, jacobians = [], []
    for k, n in enumerate((40, 55)):
        J = np.zeros((n, 1, 7))
        J[:, 0, :3] = rng.standard_normal((n, 3))
        J[:, 0, 3 + 2 * k : 5 + 2 * k] = rng.standard_normal((n, 2))
        jacobians.append(J)
        rows.append(rng.standard_normal((n, 1)))
    prior_jacobian = np.eye(7)[:2]
    blocks = Blocks(
        rows=tuple(rows), jacobians=tuple(jacobians), prior=np.array([0.3, -0.4]), prior_jacobian=prior_jacobian
    )
    R, c = triangle_by_runs(blocks)
    whole, target = triangle(blocks.jacobian, blocks.residual)
    np.testing.assert_allclose(R.T @ R, whole.T @ whole, atol=1e-12)
    assert np.linalg.solve(R, c) == pytest.approx(np.linalg.solve(whole, target))
    assert np.linalg.solve(R, c) == pytest.approx(np.linalg.lstsq(blocks.jacobian, -blocks.residual, rcond=None)[0])


def _of(residual: Callable[[Array], Array], jacobian: Callable[[Array], Array], count: list[Array]) -> Any:
    """Return a problem without bounds."""

    def blocks(x: Array, _gain: float) -> Blocks:
        count.append(x)
        J = jacobian(x)
        rows, none = residual(x)[:, None], np.zeros((0, x.size))
        return Blocks(rows=(rows,), jacobians=(J[:, None],), prior=np.zeros(0), prior_jacobian=none)

    parametrisation = SimpleNamespace(ids=(), log=())
    simulator = SimpleNamespace(equations=SimpleNamespace(joints=(0,)))
    return SimpleNamespace(
        blocks=blocks,
        simulator=simulator,
        parametrisation=parametrisation,
        constraints=lambda: (np.zeros((0, 2)), np.zeros(0)),
    )


def test_along_a_valley_where_damped_steps_promise_little_the_minimum_is_reached():
    along, across = np.array([1.0, 1.0]) / np.sqrt(2), np.array([1.0, -1.0]) / np.sqrt(2)
    J = np.array([1e4 * along, 1.0 * across])
    problem = _of(lambda x: J @ x - np.array([0.0, 8.0]), lambda _x: J, [])
    found = minimise(SumOfSquares.of(problem), np.zeros(2), tolerance=1.0)
    assert found.cost < 0.01
    assert found.converged
    assert found.calls < 6


def curved(left: float) -> tuple[Any, list[Array]]:
    """Return Rosenbrock's valley (1960), ``left`` squares above zero, and the points that were asked for."""
    asked: list[Array] = []
    rest = np.sqrt(left)
    problem = _of(
        lambda x: np.array([30.0 * (x[1] - x[0] ** 2), 3.0 * (1.0 - x[0]), rest]),
        lambda x: np.array([[-60.0 * x[0], 30.0], [-3.0, 0.0], [0.0, 0.0]]),
        asked,
    )
    return problem, asked


def test_far_from_noise_a_fit_ends_where_it_gains_no_share_of_what_is_left():
    near, steps_near = curved(0.0)
    far, steps_far = curved(1e8)
    start = np.array([-1.2, 1.0])
    assert minimise(SumOfSquares.of(near), start, tolerance=1e-3).x == pytest.approx([1.0, 1.0], abs=1e-2)
    found = minimise(SumOfSquares.of(far), start, tolerance=1e-3)
    assert found.converged
    assert len(steps_far) < len(steps_near) / 2
    assert found.cost - 1e8 < 1e-3 * 1e8 / THRESHOLDS.excess_cost_at_full_tolerance * len(steps_far) + 9.0 * 2.2**2


def test_an_unknown_that_the_residual_hardly_sees_stays_where_it_is():
    """With a derivative of 1e-10 an undamped step would take the second unknown eight units far."""
    problem = _of(lambda x: np.array([x[0] - 1.0, 1e-10 * x[1] - 8e-10]), lambda _x: np.diag([1.0, 1e-10]), [])
    found = minimise(SumOfSquares.of(problem), np.zeros(2))
    assert found.x == pytest.approx([1.0, 0.0], abs=1e-2)
    assert found.converged
