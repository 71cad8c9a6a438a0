import numpy as np
import pytest

from haptid.noise.marginal import eliminate, log_marginal


def gram_of(rng: np.random.Generator, rows: int = 30, columns: int = 4) -> np.ndarray:
    A = np.column_stack((rng.standard_normal(rows), rng.standard_normal((rows, columns))))
    return A.T @ A


def test_rounding_beside_very_large_columns_does_not_stop_it():
    rng = np.random.default_rng(0)
    A = rng.standard_normal((30, 3))
    U = 1e10 * np.column_stack((A, A @ rng.standard_normal((3, 3))))  # six columns of rank three
    r = rng.standard_normal(30)
    G = np.column_stack((r, U)).T @ np.column_stack((r, U))
    scales = np.ones(6)
    value = float(log_marginal(G, scales, np.zeros(()), 30))
    Q = np.linalg.qr(A)[0]
    left = float(r @ r - (Q.T @ r) @ (Q.T @ r))
    assert np.isfinite(value)
    assert np.isfinite(eliminate(G, scales, 1)).all()
    assert eliminate(G, scales, 1)[0, 0] == pytest.approx(left, rel=0.2)


def test_one_set_that_is_not_finite_leaves_the_others_alone():
    rng = np.random.default_rng(1)
    G = np.stack([gram_of(rng), gram_of(rng), gram_of(rng)])
    alone = log_marginal(G[[0, 2]], np.ones((2, 4)), np.zeros(2), 30)
    G[1, 2, 2] = np.nan
    found = log_marginal(G, np.ones((3, 4)), np.zeros(3), 30)
    assert np.isnan(found[1])
    np.testing.assert_allclose(found[[0, 2]], alone, rtol=1e-12)
