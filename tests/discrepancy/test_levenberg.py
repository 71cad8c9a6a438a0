"""QR run after run against one QR of everything; a narrow valley is walked to its end whatever the tolerance."""

from types import SimpleNamespace

import numpy as np
import pytest

from discrepancy.levenberg import minimise, triangle_by_runs
from identification.least_squares import triangle
from identification.problem import Blocks


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


def test_along_a_valley_where_damped_steps_promise_little_the_minimum_is_reached():
    along, across = np.array([1.0, 1.0]) / np.sqrt(2), np.array([1.0, -1.0]) / np.sqrt(2)
    J = np.array([1e4 * along, 1.0 * across])
    target = np.array([0.0, 8.0])

    def blocks(x: np.ndarray, _gain: float) -> Blocks:
        r = J @ x - target
        return Blocks(rows=(r[:, None],), jacobians=(J[:, None],), prior=np.zeros(0), prior_jacobian=np.zeros((0, 2)))

    scaling = SimpleNamespace(ids=(), log=())
    problem = SimpleNamespace(blocks=blocks, scaling=scaling, constraints=lambda: (np.zeros((0, 2)), np.zeros(0)))
    found = minimise(problem, np.zeros(2), tolerance=1.0)
    assert found.cost < 0.01
    assert found.converged
    assert found.calls < 6
