"""The search's filter and the posterior's Kalman filter are two computations of one likelihood."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.noise.correlation import Arma, Whitener
from haptid.noise.whitening import whiten

ROWS, SPACING = 4000, 0.002


def colour_of(error: float, time: float) -> Arma:
    """Return the ARMA(1,1) model of white noise of variance 1 plus error²·exp(−|Δt|/time) at even rows.

    (1 − φB) of the sum is a moving average: its variance is σ²·(1 + θ²), its covariance over one row −σ²·θ.
    """
    phi = np.exp(-SPACING / time)
    ratio = phi / (error**2 * (1 - phi**2) + 1 + phi**2)  # θ/(1 + θ²)
    theta = (1 - np.sqrt(1 - 4 * ratio**2)) / (2 * ratio)
    return Arma(phi=float(phi), theta=float(theta), sigma=float(np.sqrt(phi / theta)))


@pytest.mark.parametrize(("error", "time"), [(0.5, 0.01), (2.0, 0.02), (1.0, 0.1)])
def test_both_computations_give_one_likelihood(error, time):
    rng = np.random.default_rng(7)
    phi = np.exp(-SPACING / time)
    slow = np.empty(ROWS)
    slow[0] = error * rng.standard_normal()
    for k in range(1, ROWS):
        slow[k] = phi * slow[k - 1] + error * np.sqrt(1 - phi**2) * rng.standard_normal()
    r = slow + rng.standard_normal(ROWS)

    white, log_determinant = whiten(
        r[None], SPACING * np.arange(ROWS), noise=1.0, error=error, time=time, keep=np.ones(ROWS, dtype=bool)
    )
    exact = float(white[0] @ white[0]) + log_determinant
    whitener = Whitener.of(colour_of(error, time))
    filtered = float(np.sum(whitener(r[:, None]) ** 2)) + whitener.log_determinant(ROWS)

    assert 0.9 < white[0] @ white[0] / ROWS < 1.1
    # The filter starts from rest: a few units of −2·ln L, whatever the number of rows.
    assert abs(filtered - exact) < 12.0
    # A wrong model is further off by far.
    other = Whitener.of(colour_of(1.5 * error, time))
    wrong = float(np.sum(other(r[:, None]) ** 2)) + other.log_determinant(ROWS)
    assert abs(wrong - exact) > 2 * abs(filtered - exact)
