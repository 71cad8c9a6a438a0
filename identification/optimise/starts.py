"""Starts of a fit: `Parametrisation` and first guess in, parameter vectors out.

The first guess comes first, then scrambled Sobol points around it (Sobol 1967; Owen 1998).
"""

from __future__ import annotations

import numpy as np
from scipy.stats import norm, qmc

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def sobol_starts(parametrisation: Parametrisation, theta: Array, count: int, seed: int) -> tuple[Array, ...]:
    """Draw the starts of a fit.

    Parameters
    ----------
    parametrisation
        Free parameters with their scales, bounds and priors.
    theta
        First start, shape (n_p,).
    count
        Number of starts.
    seed
        Seed of the scrambling.

    Returns
    -------
    tuple of ndarray, shape (n_p,) each
        ``theta``, then points uniform within `THRESHOLDS.starts_over_guess` of a logarithmic parameter or within the
        unit of a linear one; a parameter with a prior is normal around ``theta`` with the prior's standard deviation,
        within two of them. All are clipped to the bounds and moved to the nearest point that meets the orderings: a
        descent that begins outside them would stay there. ``theta`` alone where no parameter is free.
    """
    n = len(parametrisation.free)
    if count < 2 or n == 0:
        return (theta,)
    # Sobol points are balanced in powers of two: the next power is drawn, and the first points are taken.
    drawn = qmc.Sobol(n, scramble=True, rng=np.random.default_rng([seed, 17])).random_base2(
        int(np.ceil(np.log2(count)))
    )
    centre, slope = parametrisation.to_coordinates(theta), parametrisation.slope(theta)
    starts = [theta]
    for point in drawn[: count - 1]:
        s = centre + np.where(parametrisation.log, np.log(THRESHOLDS.starts_over_guess), 1.0) * (2.0 * point - 1.0)
        for k, q in enumerate(parametrisation.quantities):
            if q.prior is not None:
                shift = float(np.clip(norm.ppf(np.clip(point[k], 1e-3, 1 - 1e-3)), -2.0, 2.0))
                s[k] = centre[k] + shift * q.prior.std / slope[k]
        starts.append(parametrisation.physical(parametrisation.put_in_order(s)))
    return tuple(starts)
