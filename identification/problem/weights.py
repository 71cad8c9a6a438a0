"""Time weights: `Run` in, weight of every row out (Tam, Kubica & Wang 2005, eq. 3).

The first half of a run, with its transients, has the smaller weight.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


def time_weights(run: Run, halves: tuple[float, float] = THRESHOLDS.weights_of_run_halves) -> Array:
    """Weight the squared residuals of a run's rows.

    Parameters
    ----------
    run
        Run with times t [s] and its first scored row.
    halves
        Weights of the first and the second half of the run's time.

    Returns
    -------
    ndarray, shape (n_t,)
        λ ≥ 0. The first row has weight 1 whatever ``halves`` says; other rows before ``run.score_from`` have weight 0,
        and so have rows whose own weight is 0.
    """
    weights = np.where(run.t <= 0.5 * run.t[-1], halves[0], halves[1])
    weights[: run.score_from] = 0.0
    if run.weight.size:
        weights[run.weight == 0.0] = 0.0
    # The first row is the prior N(y[0], σ²) of the fitted initial position: it has weight 1 and is never left out.
    weights[0] = 1.0
    return weights
