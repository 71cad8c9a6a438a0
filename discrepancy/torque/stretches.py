"""Residual torques of two models compared by stretches: two `TorqueFit`s in, `Gain` out.

A residual under position control is correlated: its rows are not so many facts. A run is cut into stretches of several
correlation lengths of the larger model's residual; the energies of the residuals in a stretch are what is compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.measurement.values.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Gain:
    """Gain of a larger model over a smaller one.

    Parameters
    ----------
    fitted, unseen
        n·ln(E₀/E₁) with the energies E of the residuals on fitted and on held-out stretches, and n rows counted by
        correlation lengths: twice the gain in log score.
    n_fitted
        Number n on fitted stretches.
    errors_unseen
        Decrease of energy on held-out stretches over its standard error, √K·mean(d)/std(d) of the K stretches.
    """

    fitted: float
    unseen: float
    n_fitted: float
    errors_unseen: float


def gain_of(less: TorqueFit, more: TorqueFit) -> Gain:
    """Compare two models of one study.

    Parameters
    ----------
    less, more
        Smaller and larger model.

    Returns
    -------
    Gain
    """
    # Under the larger model: what it explains is correlated as well, and would hide how much it explains.
    length = more.correlation_time
    n_fitted, n_unseen = (max(rows.size / length, 2.0) for rows in (less.fitted, less.unseen))
    decrease = _decreases(less, more, length)
    spread = float(np.std(decrease, ddof=1)) if decrease.size > 1 else np.inf
    return Gain(
        fitted=n_fitted * _log_ratio(less.fitted, more.fitted),
        unseen=n_unseen * _log_ratio(less.unseen, more.unseen),
        n_fitted=n_fitted,
        errors_unseen=float(np.sqrt(decrease.size) * np.mean(decrease) / max(spread, np.finfo(float).tiny)),
    )


def _log_ratio(less: Array, more: Array) -> float:
    tiny = np.finfo(float).tiny
    return float(np.log(max(float(less @ less), tiny) / max(float(more @ more), tiny)))


def _decreases(less: TorqueFit, more: TorqueFit, length: float) -> Array:
    """Return the decrease of energy in every held-out stretch."""
    decreases = []
    for a, b, seen in zip(less.residual, more.residual, less.study.seen, strict=True):
        rows = np.flatnonzero(~seen)
        if rows.size == 0:
            continue
        # Held-out rows that lie together are cut where they are longer than a stretch.
        together = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        longest = THRESHOLDS.torque.stretch_in_correlation_lengths * length
        for part in together:
            for piece in np.array_split(part, max(int(part.size // longest), 1)):
                decreases.append(float(np.sum(a[piece] ** 2 - b[piece] ** 2)))
    return np.array(decreases)
