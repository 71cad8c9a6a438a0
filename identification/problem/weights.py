"""Time weights of a run's rows (Tam, Kubica & Wang 2005, eq. 3): the first half, with its transients, counts less."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array, Run

PAPER = (0.5, 1.0)
"""Weights of the first and the second half of a run."""


def time_weights(run: Run, halves: tuple[float, float] = PAPER) -> Array:
    """Return λ, shape (n_t,): ``halves[0]`` up to half of the run's time, ``halves[1]`` after.

    The first row has weight 1 whatever the halves: it is the prior N(y[0], σ²) of the fitted initial position. Other
    rows before ``score_from`` weigh nothing.
    """
    weights = np.where(run.t <= 0.5 * run.t[-1], halves[0], halves[1])
    weights[: run.score_from] = 0.0
    weights[0] = 1.0
    return weights
