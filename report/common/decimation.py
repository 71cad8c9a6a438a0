"""Curves for a screen: many samples in, those that decide what each column of pixels shows out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.values.run import Array

Rows = NDArray[np.int64]


def rows_to_draw(curves: Array, columns: int) -> Rows:
    """Choose the rows that hold the least and the greatest value of each curve in every column of pixels.

    A spike of a single sample stays in the picture, which every n-th row would lose.

    Parameters
    ----------
    curves
        Curves over one increasing abscissa, shape (n_rows, n_curves).
    columns
        Number of columns of pixels.

    Returns
    -------
    ndarray of int, shape (n_kept,)
        Increasing row numbers, the first and the last among them; all rows where each curve would keep as many.
    """
    n = len(curves)
    if n <= 2 * columns:
        return np.arange(n, dtype=np.int64)
    edges = np.linspace(0, n, columns + 1).astype(np.int64)
    widest = int(np.diff(edges).max())
    rows = edges[:-1, None] + np.arange(widest)
    # Columns differ by one row at most; where one is shorter, its last place is a row of the next.
    within = rows < edges[1:, None]
    rows = np.minimum(rows, n - 1)
    kept = [np.array([0, n - 1], dtype=np.int64)]
    for curve in curves.T:
        known = within & np.isfinite(curve)[rows]
        some = known.any(axis=1)
        values = curve[rows]
        for extreme in (
            np.where(known, values, np.inf).argmin(axis=1),
            np.where(known, values, -np.inf).argmax(axis=1),
        ):
            kept.append(edges[:-1][some] + extreme[some])
    return np.unique(np.concatenate(kept))


def points_to_draw(x: Array, y: Array, columns: int, lines: int) -> Rows:
    """Choose the rows of a curve in a plane that reach another pixel than the row before them.

    Parameters
    ----------
    x, y
        Coordinates, shape (n_rows,) each.
    columns, lines
        Size of the picture [pixel].

    Returns
    -------
    ndarray of int, shape (n_kept,)
        Increasing row numbers; all rows where there are fewer than columns and lines together.
    """
    if len(x) <= columns + lines:
        return np.arange(len(x), dtype=np.int64)
    across, up = _pixels(x, columns), _pixels(y, lines)
    moved = (np.diff(across) != 0) | (np.diff(up) != 0)
    return np.flatnonzero(np.concatenate([[True], moved])).astype(np.int64)


def dots_to_draw(x: Array, y: Array, columns: int, lines: int) -> Rows:
    """Choose the first of all dots in each pixel.

    Parameters
    ----------
    x, y, columns, lines
        As `points_to_draw` takes them.

    Returns
    -------
    ndarray of int, shape (n_kept,)
        Increasing row numbers; all rows where there are fewer than columns and lines together.
    """
    if len(x) <= columns + lines:
        return np.arange(len(x), dtype=np.int64)
    _, first = np.unique(_pixels(x, columns) * lines + _pixels(y, lines), return_index=True)
    return np.sort(first).astype(np.int64)


def _pixels(values: Array, count: int) -> NDArray[np.int64]:
    finite = values[np.isfinite(values)]
    low = float(finite.min()) if finite.size else 0.0
    reach = (float(np.ptp(finite)) if finite.size else 0.0) or 1.0  # a value that never changes takes one pixel
    placed = np.nan_to_num((values - low) / reach * (count - 1), nan=-1.0, posinf=-1.0, neginf=-1.0)
    return np.asarray(np.round(placed), dtype=np.int64)
