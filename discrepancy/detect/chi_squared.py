"""Compute tail probabilities that would underflow: a statistic in, ln p out.

The tail is that of χ², or of F where the noise power that divides the statistic is itself an estimate.
"""

from __future__ import annotations

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2, f

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def log_tail(T: float, dof: float, freedom: float = np.inf) -> float:
    """Return the logarithm of a tail probability.

    Parameters
    ----------
    T
        Statistic.
    dof
        Degrees of freedom k.
    freedom
        Degrees of freedom ν to which the noise power is known; infinite where it is known exactly.

    Returns
    -------
    float
        ln P(χ²_k > T), or ln P(k·F(k, ν) > T) where ν is finite.
    """
    return float(f.logsf(T / dof, dof, freedom) if np.isfinite(freedom) else log_tails(np.asarray(T), dof))


def log_tails(T: Array, dof: float) -> Array:
    """Return ln P(χ²_k > T) of every statistic.

    Parameters
    ----------
    T
        Statistics, any shape.
    dof
        Degrees of freedom k.

    Returns
    -------
    ndarray
        Logarithms of the tail probabilities, in the shape of T.

    Notes
    -----
    For T ≫ k the tail follows from the series of Γ(a, x) with a = k/2 and x = T/2, two terms:

    Γ(a, x) ≈ x^(a−1)·e^(−x)·(1 + (a − 1)/x)

    References
    ----------
    DLMF 8.11.2.
    """
    limit = max(THRESHOLDS.detect.least_statistic_of_series, 50.0 * dof)
    a, x = dof / 2.0, np.maximum(T, limit) / 2.0
    far = (a - 1.0) * np.log(x) - x + np.log1p((a - 1.0) / x) - gammaln(a)
    return np.asarray(np.where(limit > T, chi2.logsf(np.minimum(T, limit), dof), far))
