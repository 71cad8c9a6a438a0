"""What of a signal does not repeat: positions, speeds and the signal by run in, RMS between passes out.

A *pass* is a visit of one cell of position and speed. What differs between the passes of one cell does not repeat, and
no model of position and speed can explain it: its RMS is the *floor* of such models.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

Cells = NDArray[np.int64]


def cells_of(positions: Sequence[Array], speeds: Sequence[Array]) -> list[Cells]:
    """Return the number of the cell of position and speed that each row of each run lies in.

    Parameters
    ----------
    positions, speeds
        Position and speed of one joint by run, shape (n_t,) each.

    Returns
    -------
    list of ndarray
        Numbers from 0 to `cell_count` − 1, shape (n_t,) each. Cells of position are equally wide; cells of speed hold
        equally many rows.
    """
    q, v = np.concatenate(positions), np.concatenate(speeds)
    places = np.linspace(q.min(), q.max(), THRESHOLDS.cells_of_position + 1)[1:-1]
    limits = np.quantile(v, np.linspace(0.0, 1.0, THRESHOLDS.cells_of_speed + 1)[1:-1])
    return [
        np.digitize(x, places) * THRESHOLDS.cells_of_speed + np.digitize(y, limits)
        for x, y in zip(positions, speeds, strict=True)
    ]


def cell_count() -> int:
    """Count the cells of position and speed.

    Returns
    -------
    int
        Cells of position times cells of speed.
    """
    return THRESHOLDS.cells_of_position * THRESHOLDS.cells_of_speed


def floor_of(cells: Sequence[Cells], signal: Sequence[Array]) -> float | None:
    """Estimate the RMS of what does not repeat.

    Parameters
    ----------
    cells
        Number of the cell of each row by run, shape (n_t,) each.
    signal
        Signal by run, such as the residual of a model, shape (n_t,) each; it holds what repeats as well.

    Returns
    -------
    float or None
        Root mean square of the passes' deviations from the mean of their cell, times √(K/(K − 1)) for K passes, in the
        unit of the signal; None where too few rows lie in cells that are passed more than once.
    """
    passes: dict[int, list[tuple[float, int]]] = {}
    total = 0
    for numbers, values in zip(cells, signal, strict=True):
        total += numbers.size
        for part in np.split(np.arange(numbers.size), np.flatnonzero(np.diff(numbers)) + 1):
            if part.size:
                passes.setdefault(int(numbers[part[0]]), []).append((float(values[part].mean()), part.size))
    squares, rows = 0.0, 0
    for visits in passes.values():
        means, sizes = (np.array(x) for x in zip(*visits, strict=True))
        if means.size > 1:
            centre = float(np.average(means, weights=sizes))
            squares += means.size / (means.size - 1.0) * float(np.sum(sizes * (means - centre) ** 2))
            rows += int(sizes.sum())
    if rows < THRESHOLDS.least_repeated_share_of_rows * total:
        return None
    return float(np.sqrt(squares / rows))
