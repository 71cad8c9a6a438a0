"""Weight of rows near reversals in a fit of the torque: a fit in, the fit at the weight that it asks for out.

The weight is w = min(1, RMS away from reversals over RMS near them) of the fit's own residual. What is left near
reversals is told by a fit that is not bent to them, so that the weight falls as the fit gets better: weight and fit are
repeated until the weight stays, the maximum of the likelihood with a variance for either group of rows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import rms

T = TypeVar("T")
"""A fit, of `identify` or of a search in torque."""


def weight_near_reversals(away: Array, near: Array) -> float:
    """Return the weight that a residual asks for.

    Parameters
    ----------
    away, near
        Residual torque of fitted rows away from reversals and near them [N m], any shape.

    Returns
    -------
    float
        Weight of the residual of rows near reversals [1], that of all others being 1; 1 where there are no such rows,
        or no others.
    """
    if not (away.size and near.size):
        return 1.0
    return min(1.0, rms(away) / max(rms(near), np.finfo(float).tiny))


def refit_until_weight_stays(
    found: T, weight: float, *, asked_by: Callable[[T], float], refit: Callable[[T, float], T]
) -> tuple[T, float]:
    """Repeat a fit with the weight that it asks for until that stays.

    Parameters
    ----------
    found
        Fit at the weight.
    weight
        Weight of the residual of rows near reversals [1].
    asked_by
        Function from a fit to the weight that it asks for.
    refit
        Function from a fit and a weight to the fit at that weight, begun at the estimates of the first.

    Returns
    -------
    found, weight
        The last fit and its weight.
    """
    for _ in range(THRESHOLDS.most_reweighings):
        asked = asked_by(found)
        if abs(asked - weight) <= THRESHOLDS.least_change_of_weight * weight:
            break
        found, weight = refit(found, asked), asked
    return found, weight
