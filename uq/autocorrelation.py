"""Integrated autocorrelation time of ensembles (Goodman and Weare 2010; Sokal 1996)."""

from __future__ import annotations

import emcee
import numpy as np

from measurement.run import Array


def autocorrelation_time(chain: Array) -> Array:
    """τ of every coordinate [steps], averaged over ensembles.

    Parameters
    ----------
    chain
        Shape (n_ensembles, n_steps, n_walkers, n). The autocorrelation function is averaged over the walkers of an
        ensemble, and summed over Sokal's window (the first lag above 5τ).

    Returns
    -------
    ndarray, shape (n,)
        At least 1.
    """
    times = [emcee.autocorr.integrated_time(ensemble, quiet=True, tol=0) for ensemble in chain]
    return np.maximum(np.mean(times, axis=0), 1.0)
