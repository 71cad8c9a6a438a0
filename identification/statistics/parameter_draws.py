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
from haptid.support.linear_algebra import correlation_of


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


def draw_free(
    equations: Equations, theta: Array, free: Sequence[str], covariance: Array, *, count: int, rng: np.random.Generator
) -> Array:
    """Draw as `draw_parameters`, and return the fitted parameters alone.

    Parameters
    ----------
    equations, theta, free, covariance, count, rng
        As for `draw_parameters`.

    Returns
    -------
    ndarray, shape (count, n_free)
        One column for each of ``free``, in its order.
    """
    place = {q.id: k for k, q in enumerate(equations.parameters)}
    drawn = draw_parameters(equations, theta, free, covariance, count=count, rng=rng)
    return np.asarray(drawn[:, [place[id] for id in free]])


def _root(covariance: Array, slope: Array) -> Array:
    """Return a root of the covariance of the coordinates, shape (n_free, n_free), from that of the parameters."""
    in_coordinates = covariance / np.outer(slope, slope)
    # Correlations instead of covariances: rounding must not depend on the parameters' units.
    correlation, std = correlation_of(in_coordinates)
    values, vectors = np.linalg.eigh(correlation)
    return np.asarray(std[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _raise(theta: Array, chosen: Parametrisation) -> Array:
    """Return a parameter set whose orderings are met by raising the parameter that is too small."""
    place = {q.id: i for i, q in enumerate(chosen.equations.parameters)}
    result = theta.copy()
    for above, below in chosen.equations.orderings:
        result[place[above]] = max(result[place[above]], result[place[below]])
    return result
