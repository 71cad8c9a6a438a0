"""What repeats with the drive: harmonics of the torque's frequency, a basis for residuals that are not noise."""

from __future__ import annotations

import numpy as np

from haptid.measurement.signals.cycles import Cycles
from haptid.measurement.values.run import Array, Run

HIGHEST = 40.0
"""Highest angular frequency of a harmonic [rad/s]."""
MOST = 24
"""Most harmonics of a run."""


def harmonics(run: Run, cycles: Cycles, *, highest: float = HIGHEST, most: int = MOST, drifting: bool = False) -> Array:
    """Return 1, cos(hωt), sin(hωt) for h = 1.. as columns (n_t, k); with ``drifting`` each also times time.

    A run without cycles gets cosines of half-integer multiples of its own length instead.
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
