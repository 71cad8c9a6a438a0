"""Which cycle of the drive every row lies in: the unit that amplitude scatter knows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.signals.cycles import PERIODIC, SLIVER, find_cycles
from haptid.measurement.values.run import Run


def cycle_index(run: Run) -> NDArray[np.int64]:
    """Return the number of the cycle of every row, from 0, shape (n_t,).

    As `find_cycles`; runs of less than two cycles are cut too, where the drive's phase passes a
    multiple of 2π, for each begun cycle has an amplitude of its own.
    """
    found = find_cycles(run)
    if found.count > 1 or found.share < PERIODIC or found.omega <= 0:
        return found.index
    t, u = run.t, run.u[:, 0]
    basis = np.stack([np.cos(found.omega * t), np.sin(found.omega * t), np.ones_like(t)], axis=1)
    a, b, _ = np.linalg.lstsq(basis, u, rcond=None)[0]
    turns = (found.omega * t + np.arctan2(-b, a)) / (2 * np.pi)
    number = np.floor(turns + 1e-9).astype(np.int64)
    parts = [float(np.mean(number == c)) * turns[-1] for c in np.unique(number)]
    return np.asarray(number - number[0]) if min(parts) > SLIVER else found.index
