"""The sandwich's middle by convolution is the sum over lags that defines it."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.statistics.covariance import sum_over_lags


@pytest.mark.parametrize(("rows", "lags"), [(300, 1), (300, 40), (2000, 700), (50, 49)])
def test_one_convolution_is_the_sum_over_lags(rows: int, lags: int):
    g = np.random.default_rng(0).standard_normal((rows, 5)).cumsum(axis=0)
    weights = np.exp(-np.arange(lags) / 100.0) * (1.0 - np.arange(lags) / (lags + 1.0))
    expected = weights[0] * g.T @ g
    for lag in range(1, lags):
        cross = g[lag:].T @ g[:-lag]
        expected += weights[lag] * (cross + cross.T)
    np.testing.assert_allclose(sum_over_lags(g, weights), expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())
