"""Long simulations in pieces: Python handles Ctrl-C and SIGTERM only between calls into compiled code.

Times of the rows come in, slices of rows go out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.model.thresholds import THRESHOLDS


def inner_steps(t: NDArray[np.float64], step: float) -> NDArray[np.int64]:
    """Count the equal inner steps into which the kernel divides each interval between rows.

    Parameters
    ----------
    t
        Times of the rows [s], shape (n_t,).
    step
        Longest inner step [s].

    Returns
    -------
    ndarray of int, shape (n_t - 1,)
        As ``advance`` of ``stepper.h`` counts them: an interval longer than ``step`` by rounding alone is not divided.
    """
    return np.asarray(np.diff(t) / step - 1e-6).astype(np.int64) + 1


def pieces(t: NDArray[np.float64], step: float, most: int = THRESHOLDS.most_inner_steps_of_call) -> list[slice]:
    """Cut rows into pieces of at most ``most`` inner steps; the last row of a piece is the first one of the next.

    A pause between two rows is not cut: it is one piece, however long.

    Parameters
    ----------
    t
        Times of the rows [s], shape (n_t,).
    step
        Longest inner step [s].
    most
        Largest number of inner steps of a piece.

    Returns
    -------
    list of slice
        Slices of rows in order; two neighbours share one row.
    """
    if t.size < 3 or t.size + (t[-1] - t[0]) / step <= most:
        return [slice(0, t.size)]
    taken = np.cumsum(np.maximum(np.ceil(np.diff(t) / step), 1.0))
    cuts, done = [0], 0.0
    while taken[-1] - done > most:
        # the last row within the limit; at least one row further, where a single pause exceeds the limit
        row = max(int(np.searchsorted(taken, done + most, side="right")), cuts[-1] + 1)
        if row >= t.size - 1:
            break
        cuts.append(row)
        done = taken[row - 1]
    return [slice(a, b + 1) for a, b in zip(cuts, [*cuts[1:], t.size - 1], strict=True)]
