"""Cycles of a run with every piece counted: an amplitude of its own may begin in the last rows of a run."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from haptid.measurement.signals.cycles import Cycles, find_cycles
from haptid.measurement.values.run import Run


@lru_cache(maxsize=64)
def whole_cycles(run: Run) -> Cycles:
    """Return `measurement.signals.cycles.find_cycles` of a run with short pieces at either end as cycles of their own.

    Cycle k holds the rows with k ≤ (ωt + φ)/2π < k + 1 for the torque's strongest line A·cos(ωt + φ).
    """
    found = find_cycles(run)
    if found.count < 2:
        return found
    turns = np.floor(found.turns).astype(np.int64)
    return replace(found, index=turns - turns[0])
