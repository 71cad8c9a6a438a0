"""Cycles of a run with every piece counted: an amplitude of its own may begin in the last rows of a run."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from measurement.cycles import Cycles, find_cycles
from measurement.run import Run

EDGE = 1e-4
"""Share of a cycle by which a boundary may be missed by rounding."""


@lru_cache(maxsize=64)
def whole_cycles(run: Run) -> Cycles:
    """Return `measurement.cycles.find_cycles` of a run with short pieces at either end as cycles of their own.

    Cycle k holds the rows with k ≤ (ωt + φ)/2π < k + 1 for the torque's strongest line A·cos(ωt + φ).
    """
    found = find_cycles(run)
    if found.count < 2:
        return found
    wave = found.omega * run.t
    basis = np.column_stack((np.cos(wave), np.sin(wave), np.ones(wave.size)))
    a, b, _ = np.linalg.lstsq(basis, run.u[:, 0], rcond=None)[0]
    turns = np.floor((wave + np.arctan2(-b, a)) / (2 * np.pi) + EDGE).astype(np.int64)
    return replace(found, index=turns - turns[0])
