"""The distribution of the band's energy under noise, by draws."""

import numpy as np
from scipy.stats import kstest

from haptid.discrepancy.detect.omnibus import satterthwaite


def test_p_of_noise_is_uniform_and_of_a_wave_is_not():
    rng = np.random.default_rng(1)
    n, k, m = 400, 6, 60
    Q = np.linalg.qr(rng.standard_normal((n, k)))[0]
    B = np.linalg.qr(np.cos(np.pi * np.arange(m) * (np.arange(n)[:, None] + 0.5) / n))[0]
    moved = B.T @ Q

    def p_of(r: np.ndarray) -> float:
        left = r - Q @ (Q.T @ r)
        return satterthwaite(B.T @ left, moved)[2]

    drawn = [p_of(rng.standard_normal(n)) for _ in range(2000)]
    assert kstest(drawn, "uniform").pvalue > 1e-3
    assert np.mean(np.array(drawn) < 0.01) < 0.02
    wave = np.sin(2 * np.pi * 7 * np.arange(n) / n)
    assert p_of(wave + rng.standard_normal(n)) < 1e-6
