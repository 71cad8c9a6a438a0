"""What the data say about each parameter: statuses, and combinations where single parameters stay open.

A parameter counts as known where its standard deviation is below half of its size: of 1 for a logarithm (50 %), of its
value or typical size otherwise. One with a prior is ``prior`` where the data did not halve the prior's width.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.problem.parametrisation import Scaling
from haptid.identification.result.fit import Combination
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import inverse, profiled

KNOWN = 0.5
SMALL, LONGEST = 0.1, 4
"""A member of a combination has at least this share of it; combinations of more members say nothing to a reader."""
EDGE = 1e-4
"""Distance from a bound, as a share of the range, within which a parameter lies on it."""


def known_sizes(scaling: Scaling, s: Array) -> Array:
    """Return the scaled standard deviation below which each free parameter counts as known, shape (n_free,)."""
    value = np.abs(scaling.physical(s)[list(scaling.free)]) / scaling.unit
    return KNOWN * np.where(scaling.log, 1.0, np.maximum(value, 1.0))


def on_bound(scaling: Scaling, s: Array) -> Array:
    """Return which free parameters lie on a bound, shape (n_free,)."""
    lower, upper = scaling.bounds
    reach = EDGE * np.where(np.isfinite(upper - lower), upper - lower, 0.0)
    return np.asarray((s - lower <= reach) | (upper - s <= reach))


def statuses(scaling: Scaling, s: Array, std: Array) -> dict[str, str]:
    """Return the status of every parameter by id; ``s`` and ``std`` are scaled, shape (n_free,)."""
    result = {q.id: "fixed" for q in scaling.equations.parameters if q.fixed}
    sizes, edge = known_sizes(scaling, s), on_bound(scaling, s)
    theta = scaling.physical(s)
    slope = scaling.slope(theta)
    for k, q in enumerate(scaling.quantities):
        if edge[k]:
            result[q.id] = "at_bound"
        elif q.prior is not None:
            result[q.id] = "prior" if std[k] * slope[k] > KNOWN * q.prior.std else "identified"
        else:
            result[q.id] = "unidentifiable" if std[k] > sizes[k] else "identified"
    return result


def combinations(scaling: Scaling, s: Array, information: Array, status: dict[str, str]) -> tuple[Combination, ...]:
    """Return what the data alone know of the parameters that stay open.

    Parameters
    ----------
    information
        Scaled Fisher information of the data, initial states marginalised, shape (n_free, n_free).
    """
    sizes = known_sizes(scaling, s)
    H = information * np.outer(sizes, sizes)
    members = _members(scaling, H, status)
    if len(members) < 2:
        return ()
    values, vectors = np.linalg.eigh(profiled(H, members))
    theta = scaling.physical(s)[list(scaling.free)]
    slope = scaling.slope(scaling.physical(s))
    found = []
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        keep = np.abs(vector) > SMALL
        if value > 1.0 and 1 < int(keep.sum()) <= LONGEST:
            row = vector / (sizes * slope)[members]
            lead = row[int(np.argmax(np.abs(vector)))]
            chosen = {scaling.ids[m]: float(c / lead) for m, c, k in zip(members, row, keep, strict=True) if k}
            total = float(sum(c * theta[scaling.ids.index(id)] for id, c in chosen.items()))
            found.append(Combination(coefficients=chosen, value=total, std=float(1.0 / np.sqrt(value) / abs(lead))))
    return tuple(found)


def _members(scaling: Scaling, H: Array, status: dict[str, str]) -> list[int]:
    """Open parameters, and those that the data tie to them (correlation above 0.95)."""
    open_ones = [k for k, id in enumerate(scaling.ids) if status[id] in ("unidentifiable", "prior")]
    covariance = inverse(H + 1e-9 * np.eye(len(H)))
    scale = np.sqrt(np.diag(covariance))
    correlation = np.abs(covariance / np.outer(scale, scale))
    return [k for k in range(len(H)) if k in open_ones or any(correlation[k, o] > 0.95 for o in open_ones)]
