"""Whether independent ensembles found the same mode."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import symmetric_inverse

APART = 6.0
"""Distance of two ensembles' means, in standard deviations of a single ensemble, from which they count as two modes."""


def count_modes(chain: Array) -> int:
    """Count the groups of the ensembles (n_ensembles, n_steps, n_walkers, n): means closer than ``APART`` join.

    The distance is Mahalanobis' with the mean covariance within ensembles, divided by √n.
    """
    ensembles, _, _, n = chain.shape
    flat = chain.reshape(ensembles, -1, n)
    means = flat.mean(axis=1)
    within = np.mean([np.cov(x.T).reshape(n, n) for x in flat], axis=0)
    precision = symmetric_inverse(within)
    groups: list[Array] = []
    for mean in means:
        near = [d for g in groups if (d := float(np.sqrt((mean - g) @ precision @ (mean - g) / n))) < APART]
        if not near:
            groups.append(mean)
    return len(groups)
