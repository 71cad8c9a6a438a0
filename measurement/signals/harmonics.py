"""Basis functions for residuals that repeat with the drive: `Run` and its `Cycles` in, columns (n_t, k) out."""

from __future__ import annotations

import numpy as np

from haptid.measurement.signals.cycles import Cycles
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


def harmonics(
    run: Run,
    cycles: Cycles,
    *,
    highest: float = THRESHOLDS.highest_harmonic_rad_per_s,
    most: int = THRESHOLDS.most_harmonics,
    drifting: bool = False,
) -> Array:
    """Return a basis of harmonics of the drive's frequency.

    Parameters
    ----------
    run
        Run whose rows the basis has.
    cycles
        Cycles of ``run``; their ``omega`` is the fundamental frequency ω.
    highest
        Highest angular frequency of a harmonic [rad/s].
    most
        Most harmonics.
    drifting
        Whether each function also appears multiplied by t/T − 1/2, with T the length of the run [s].

    Returns
    -------
    ndarray, shape (n_t, k)
        Columns 1, cos(hωt) and sin(hωt) for h = 1, 2, …, at least up to h = 1. A run with fewer than two cycles gets
        cos(πkt/T), k = 0, 1, …, instead: harmonics of half a cycle per run.
    """
    t = run.t
    if cycles.count < 2:
        k = np.arange(min(most * 2, int(highest * t[-1] / np.pi)) + 1)
        basis = np.cos(np.pi * k * t[:, None] / t[-1])
    else:
        h = np.arange(1, max(1, min(most, int(highest / cycles.omega))) + 1)
        phase = cycles.omega * t[:, None] * h
        basis = np.column_stack((np.ones(t.size), np.cos(phase), np.sin(phase)))
    if drifting:
        basis = np.column_stack((basis, basis * (t / t[-1] - 0.5)[:, None]))
    return np.asarray(basis)
