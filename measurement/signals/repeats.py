"""What of a signal does not repeat: positions, speeds and the signal by run in, RMS between passes out.

A *pass* is a visit of one cell of position and speed. What differs between the passes of one cell does not repeat, and
no model of position and speed can explain it: its RMS is the *floor* of such models.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

Cells = NDArray[np.int64]


def cells_of(positions: Sequence[Array], speeds: Sequence[Array], fineness: int = 1) -> list[Cells]:
    """Return the number of the cell of position and speed that each row of each run lies in.

    Parameters
    ----------
    positions, speeds
        Position and speed of one joint by run, shape (n_t,) each.
    fineness
        Into how many each cell of position is cut.

    Returns
    -------
    list of ndarray
        Numbers from 0 to `cell_count` − 1, shape (n_t,) each. Cells of position are equally wide; cells of speed hold
        equally many rows.
    """
    q, v = np.concatenate(positions), np.concatenate(speeds)
    places = np.linspace(q.min(), q.max(), fineness * THRESHOLDS.cells_of_position + 1)[1:-1]
    limits = np.quantile(v, np.linspace(0.0, 1.0, THRESHOLDS.cells_of_speed + 1)[1:-1])
    return [
        np.digitize(x, places) * THRESHOLDS.cells_of_speed + np.digitize(y, limits)
        for x, y in zip(positions, speeds, strict=True)
    ]


def cell_count(fineness: int = 1) -> int:
    """Count the cells of position and speed.

    Parameters
    ----------
    fineness
        As `cells_of` takes it.

    Returns
    -------
    int
        Cells of position times cells of speed.
    """
    return fineness * THRESHOLDS.cells_of_position * THRESHOLDS.cells_of_speed


def lowest_floor(
    positions: Sequence[Array], speeds: Sequence[Array], signals: Sequence[Array], rows: Sequence[NDArray[np.bool_]]
) -> float | None:
    """Estimate the RMS of what does not repeat, in cells as fine as the data allow.

    A ripple finer than a cell differs between the passes of a cell though it repeats. Finer cells hold fewer rows of a
    pass, whose noise averages out less: the cells with the lowest floor show most of what repeats.

    Parameters
    ----------
    positions, speeds
        As `cells_of` takes them.
    signals
        Signal by run, shape (n_t,) each.
    rows
        Rows that count, shape (n_t,) each.

    Returns
    -------
    float or None
        The lowest `floor_of`, in the unit of the signal; None where none is known.
    """
    kept = _only(signals, rows)
    # The first is the coarsest.
    cells = [_only(cells_of(positions, speeds, fineness), rows) for fineness in THRESHOLDS.fineness_of_cells]
    floors = [floor_of(fine, kept, cells[0]) for fine in cells]
    return min((floor for floor in floors if floor is not None), default=None)


def _only(values: Sequence[NDArray[Any]], rows: Sequence[NDArray[np.bool_]]) -> list[NDArray[Any]]:
    return [one[own] for one, own in zip(values, rows, strict=True)]


def floor_of(cells: Sequence[Cells], signal: Sequence[Array], coarse: Sequence[Cells] | None = None) -> float | None:
    """Estimate the RMS of what does not repeat.

    Parameters
    ----------
    cells
        Number of the cell of each row by run, shape (n_t,) each.
    signal
        Signal by run, such as the residual of a model, shape (n_t,) each; it holds what repeats as well.
    coarse
        Cells whose visits are the passes; ``cells`` where None. A reading that trembles over the edges of fine cells
        visits them many times in one pass of a coarse one.

    Returns
    -------
    float or None
        Root mean square of the passes' deviations from the mean of their cell, times √(K/(K − 1)) for K passes, in the
        unit of the signal; None where too few rows lie in cells that are passed more than once.
    """
    visit = np.concatenate([np.flatnonzero(np.r_[True, np.diff(x) != 0]).searchsorted(np.arange(x.size), "right")
                            for x in coarse or cells])  # fmt: skip
    starts = np.cumsum([0, *(x.size for x in cells)])[:-1]
    run = np.searchsorted(starts, np.arange(visit.size), side="right")
    cell, values = np.concatenate(cells), np.concatenate(signal)
    passes, place, sizes = np.unique(np.stack([cell, run, visit]), axis=1, return_inverse=True, return_counts=True)
    means = np.bincount(place.ravel(), values) / sizes
    _, own, count = np.unique(passes[0], return_inverse=True, return_counts=True)
    centre = (np.bincount(own, means * sizes) / np.bincount(own, sizes))[own]
    several = count[own] > 1
    rows = int(sizes[several].sum())
    if rows < THRESHOLDS.least_repeated_share_of_rows * cell.size or rows == 0:
        return None
    K = count[own][several]
    squares = np.sum(K / (K - 1.0) * sizes[several] * (means - centre)[several] ** 2)
    return float(np.sqrt(squares / rows))
