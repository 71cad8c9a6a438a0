"""Draws of parameters from the covariance of their fit: estimate and covariance in, parameter sets out.

1. Carry the covariance to the coordinates in which the fit moved, C_s = C_p/(p'·p'ᵀ) with the slope p' = dp/ds.
2. Draw s from the normal distribution about the estimate, and map it back: a positive parameter stays positive.
3. Draw again where an ordering as Fs ≥ Fc is not met.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations


def draw_parameters(
    equations: Equations,
    theta: Array,
    free: Sequence[str],
    covariance: Array,
    *,
    count: int,
    rng: np.random.Generator,
) -> Array:
    """Draw parameter sets that a joint can have.

    Parameters
    ----------
    equations
        Equations with bounds and orderings.
    theta
        Estimate, shape (n_p,).
    free
        Ids of the fitted parameters.
    covariance
        Covariance of the fitted parameters in their units, shape (n_free, n_free).
    count
        Number of draws.
    rng
        Random numbers.

    Returns
    -------
    ndarray, shape (count, n_p)
        In the order of ``equations.parameters``, within their bounds; those that were not fitted keep their value.

    Notes
    -----
    Where an ordering is met by hardly any draw, the rest is put in order by raising the parameter that is too small, as
    a fit that ends at the constraint has both equal.
    """
    others = {q.id: {"fixed": True} for q in equations.parameters if q.id not in free}
    chosen = Parametrisation.of(equations.with_parameters(others))
    if not chosen.free:
        return np.tile(theta, (count, 1))
    order = [list(free).index(id) for id in chosen.ids]
    root = _root(covariance[np.ix_(order, order)], chosen.slope(theta))
    centre = chosen.to_coordinates(theta)
    kept: list[Array] = []
    for _ in range(THRESHOLDS.most_rounds_of_draws):
        drawn = np.tile(theta, (count, 1))
        drawn[:, list(chosen.free)] = chosen.values(centre + rng.standard_normal((count, root.shape[1])) @ root.T)
        met = chosen.meets_orderings(drawn)
        kept += list(drawn[met])
        if len(kept) >= count:
            return np.array(kept[:count])
    kept += [_raise(row, chosen) for row in drawn[~met]]
    return np.array(kept[:count])


def _root(covariance: Array, slope: Array) -> Array:
    """Return a root of the covariance of the coordinates, shape (n_free, n_free), from that of the parameters."""
    in_coordinates = covariance / np.outer(slope, slope)
    # Correlations instead of covariances: rounding must not depend on the parameters' units.
    std = np.sqrt(np.maximum(np.diag(in_coordinates), 1e-300))
    values, vectors = np.linalg.eigh(in_coordinates / np.outer(std, std))
    return np.asarray(std[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _raise(theta: Array, chosen: Parametrisation) -> Array:
    """Return a parameter set whose orderings are met by raising the parameter that is too small."""
    place = {q.id: i for i, q in enumerate(chosen.equations.parameters)}
    result = theta.copy()
    for above, below in chosen.equations.orderings:
        result[place[above]] = max(result[place[above]], result[place[below]])
    return result
