"""Integrated autocorrelation time of ensembles: chains in, τ of every coordinate out.

References
----------
Goodman, J., and Weare, J. (2010). Ensemble samplers with affine invariance. Communications in Applied Mathematics and
Computational Science 5, 65–80.
Sokal, A. (1996). Monte Carlo methods in statistical mechanics: foundations and new algorithms.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array
from haptid.uq.thresholds import THRESHOLDS


def autocorrelation_time(chain: Array) -> Array:
    """Return τ of every coordinate [steps], averaged over ensembles.

    Parameters
    ----------
    chain
        Shape (n_ensembles, n_steps, n_walkers, n).

    Returns
    -------
    ndarray, shape (n,)
        τ = 1 + 2·Σ ρ(k) up to Sokal's window, the first lag M ≥ 5·τ(M); at least 1.

    Notes
    -----
    The autocovariance is taken about the mean of all walkers of an ensemble and averaged over them before it is
    normalised. So a walker that never moves counts as correlated, where a normalisation walker by walker would divide
    by zero; and τ of short chains is biased less.
    """
    return np.maximum(np.mean([_times(ensemble) for ensemble in chain], axis=0), 1.0)


def _times(ensemble: Array) -> Array:
    steps = ensemble.shape[0]
    centred = ensemble - ensemble.mean(axis=(0, 1))
    spectrum = np.abs(np.fft.rfft(centred, 2 * steps, axis=0)) ** 2  # padded: the correlation must not wrap around
    covariance = np.fft.irfft(spectrum.mean(axis=1), axis=0)[:steps] / np.arange(steps, 0, -1)[:, None]
    return np.array([_sum_to_window(rho / rho[0]) if rho[0] > 0 else float(steps) for rho in covariance.T])


def _sum_to_window(rho: Array) -> float:
    times = 2.0 * np.cumsum(rho) - 1.0
    inside = np.flatnonzero(np.arange(rho.size) >= THRESHOLDS.window_over_autocorrelation_time * times)
    return float(times[inside[0]] if inside.size else times.max())  # a chain too short for its window: the largest sum
