"""Tail of χ² where it underflows, and of F where the noise that divides it is itself an estimate."""

from __future__ import annotations

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2, f

from haptid.measurement.values.run import Array

FAR = 500.0
"""Statistic beyond which the asymptotic series is taken."""


def log_tail(T: float, dof: float, freedom: float = np.inf) -> float:
    """Return ln P(χ²_k > T), of k·F(k, ν) where the noise's power is known to ν degrees of freedom only."""
    return float(f.logsf(T / dof, dof, freedom) if np.isfinite(freedom) else log_tails(np.asarray(T), dof))


def log_tails(T: Array, dof: float) -> Array:
    """Return ln P(χ²_k > T) of every T.

    For T ≫ k by the series of Γ(a, x), a = k/2, x = T/2 (DLMF 8.11.2, two terms).

    Γ(a, x) ≈ x^(a−1)·e^(−x)·(1 + (a − 1)/x)
    """
    limit = max(FAR, 50.0 * dof)
    a, x = dof / 2.0, np.maximum(T, limit) / 2.0
    far = (a - 1.0) * np.log(x) - x + np.log1p((a - 1.0) / x) - gammaln(a)
    return np.asarray(np.where(limit > T, chi2.logsf(np.minimum(T, limit), dof), far))
