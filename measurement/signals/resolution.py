"""Estimate the encoder step: readings of one joint in, step in the same unit out.

1. Guess the step as the smallest difference between distinct readings, or its half or third.
2. Refine the guess by least squares over ever larger differences.
3. Accept it where all readings lie on the levels of that step.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import rms

ROUNDING_OVER_RANGE = 1e-9
"""Differences below this share of the range are rounding of binary numbers, not steps."""


def estimate_resolution(y: Array) -> float:
    """Estimate the step h of a quantised reading.

    Parameters
    ----------
    y
        Readings [rad] or [m], shape (n_t,).

    Returns
    -------
    float
        Step h in the unit of ``y``, 0 where there is none. A file rounded to decimals has that rounding as its step.

    Notes
    -----
    All values of a quantised reading are y₀ + k·h with integer k. The smallest difference between distinct values
    (and its half and third, should no two neighbouring levels occur) is a first guess of h. It is refined by
    h = Σ k·d / Σ k² over ever larger differences d = y − y₀ with k = round(d/h), the least-squares slope of d over k.
    The guess is accepted where max |d − k·h| < h/6 and the rms is below h/12; the rms of a reading without steps
    would be h/√12.
    """
    levels = np.unique(y)
    steps = np.diff(levels)
    steps = steps[steps > ROUNDING_OVER_RANGE * np.ptp(levels)] if steps.size else steps
    if steps.size < 2:
        return 0.0
    offsets = levels - levels[0]
    for divisor in (1, 2, 3):
        step = _refine(steps, offsets, float(steps.min()) / divisor)
        if step > 0:
            return step
    return 0.0


def _refine(steps: Array, offsets: Array, guess: float) -> float:
    """Refine ``guess`` on the small steps, then on ever longer offsets; 0 where the levels do not fit it."""
    step = _fit_levels(steps[steps < 10 * guess], guess)
    # An error of h grows with k: far offsets would be rounded to the wrong k before near ones have refined h.
    reach = 10 * step
    while reach < offsets[-1]:
        reach = min(4 * reach, float(offsets[-1]))
        step = _fit_levels(offsets[(offsets > 0) & (offsets <= reach)], step)
    misfit = offsets - step * np.round(offsets / step)
    # All offsets share the rounding of the first level; their median takes it out.
    misfit -= np.median(misfit)
    fits = np.abs(misfit).max() < step / 6 and rms(misfit) < step / 12
    return step if fits else 0.0


def _fit_levels(differences: Array, step: float) -> float:
    counts = np.round(differences / step)
    total = float(counts @ counts)
    return float(counts @ differences) / total if total > 0 else step
