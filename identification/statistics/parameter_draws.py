"""Draws of the parameters of one configuration from the covariance of its fit: `Fit` in, parameter sets out.

1. Carry the covariance to the coordinates in which the fit moved, C_s = C_p/(p'·p'ᵀ) with the slope p' = dp/ds.
2. Draw s from the normal distribution about the estimate, and map it back: a positive parameter stays positive.
3. Draw again where an ordering as Fs ≥ Fc is not met.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def draw_parameters(fit: Fit, count: int, rng: np.random.Generator) -> Array:
    """Draw parameter sets that a joint can have.

    Parameters
    ----------
    fit
        Fit of one configuration.
    count
        Number of draws.
    rng
        Random numbers.

    Returns
    -------
    ndarray, shape (count, n_p)
        In the order of ``fit.equations.parameters``, within their bounds; those that were not fitted keep their value.

    Notes
    -----
    Where an ordering is met by hardly any draw, the rest is put in order by raising the parameter that is too small, as
    a fit that ends at the constraint has both equal.
    """
    others = {q.id: {"fixed": True} for q in fit.equations.parameters if q.id not in fit.free}
    chosen = Parametrisation.of(fit.equations.with_parameters(others))
    if not chosen.free:
        return np.tile(fit.theta, (count, 1))
    root, centre = _root(fit, chosen), chosen.to_coordinates(fit.theta)
    kept: list[Array] = []
    for _ in range(THRESHOLDS.most_rounds_of_draws):
        theta = np.tile(fit.theta, (count, 1))
        theta[:, list(chosen.free)] = chosen.values(centre + rng.standard_normal((count, root.shape[1])) @ root.T)
        met = chosen.meets_orderings(theta)
        kept += list(theta[met])
        if len(kept) >= count:
            return np.array(kept[:count])
    kept += [_raise(row, chosen) for row in theta[~met]]
    return np.array(kept[:count])


def _root(fit: Fit, chosen: Parametrisation) -> Array:
    """Return a root of the covariance of the coordinates, shape (n_free, n_free), in the order of `Parametrisation`."""
    order = [fit.free.index(id) for id in chosen.ids]
    slope = chosen.slope(fit.theta)
    covariance = fit.covariance[np.ix_(order, order)] / np.outer(slope, slope)
    # Correlations instead of covariances: rounding must not depend on the parameters' units.
    std = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(std, std))
    return np.asarray(std[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _raise(theta: Array, chosen: Parametrisation) -> Array:
    """Return a parameter set whose orderings are met by raising the parameter that is too small."""
    place = {q.id: i for i, q in enumerate(chosen.equations.parameters)}
    result = theta.copy()
    for above, below in chosen.equations.orderings:
        result[place[above]] = max(result[place[above]], result[place[below]])
    return result
