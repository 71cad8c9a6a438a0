"""Number of separate modes among independent ensembles: chains in, a count out."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import symmetric_inverse
from haptid.uq.thresholds import THRESHOLDS


def count_modes(chain: Array) -> int:
    """Count the groups that the means of the ensembles form.

    Parameters
    ----------
    chain
        Chains of the ensembles, shape (n_ensembles, n_steps, n_walkers, n).

    Returns
    -------
    int
        1 where all ensembles sample the same mode.

    Notes
    -----
    An ensemble joins a group whose first mean is closer than `THRESHOLDS.least_distance_of_modes_in_std`. The distance
    is Mahalanobis' with the mean covariance within ensembles, divided by √n.
    """
    ensembles, _, _, n = chain.shape
    flat = chain.reshape(ensembles, -1, n)
    means = flat.mean(axis=1)
    within = np.mean([np.cov(x.T).reshape(n, n) for x in flat], axis=0)  # of one coordinate np.cov gives a scalar
    precision = symmetric_inverse(within)
    groups: list[Array] = []
    for mean in means:
        distances = [float(np.sqrt((mean - g) @ precision @ (mean - g) / n)) for g in groups]
        if not any(distance < THRESHOLDS.least_distance_of_modes_in_std for distance in distances):
            groups.append(mean)
    return len(groups)
