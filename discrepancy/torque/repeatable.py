"""What of a residual torque repeats: `TorqueFit` in, floor and black box out.

A *pass* is a visit of one cell of position and speed. What differs between the passes of one cell does not repeat, and
no model of position and speed can explain it: its RMS is the *floor*. A *black box* holds all that is bound to position
and speed, without physics: the table of the cells' mean residual on fitted rows, or a polynomial of the position for
each direction of motion. What the better of them leaves on held-out rows is the aim of named effects.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, rms
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.values.run import Array

Cells = NDArray[np.int64]
LEAST_REPEATED_SHARE = 0.2
"""Share of the rows in cells with several passes, below which the floor counts as unknown [1]."""


def floor_of(model: TorqueFit) -> float | None:
    """Estimate the RMS of the residual torque that does not repeat.

    Parameters
    ----------
    model
        Fitted model; its residual holds what repeats as well.

    Returns
    -------
    float or None
        Root mean square of the passes' deviations from the mean of their cell [N m], K/(K − 1) for K passes; None where
        too few rows lie in cells that are passed more than once.
    """
    deviations, rows, total = [], 0, 0
    passes: dict[int, list[tuple[float, int]]] = {}
    for all_cells, all_rows, moving in zip(_cells(model), model.residual, model.study.moving, strict=True):
        cells, residual = all_cells[moving], all_rows[moving]
        total += cells.size
        for part in np.split(np.arange(cells.size), np.flatnonzero(np.diff(cells)) + 1):
            passes.setdefault(int(cells[part[0]]), []).append((float(residual[part].mean()), part.size))
    for visits in passes.values():
        means, sizes = (np.array(x) for x in zip(*visits, strict=True))
        if means.size < 2:
            continue
        centre = float(np.average(means, weights=sizes))
        scale = means.size / (means.size - 1.0)
        deviations.append(scale * np.sum(sizes * (means - centre) ** 2))
        rows += int(sizes.sum())
    if rows < LEAST_REPEATED_SHARE * total:
        return None
    return float(np.sqrt(np.sum(deviations) / rows))


def black_box_rms(model: TorqueFit) -> float | None:
    """Compute what the better black box leaves of the residual torque on held-out rows.

    Parameters
    ----------
    model
        Model whose residual on fitted rows the black boxes learn; a cell without fitted rows holds 0.

    Returns
    -------
    float or None
        RMS [N m]; None where no row is held out.
    """
    if model.unseen.size == 0:
        return None
    cells = _cells(model)
    count = THRESHOLDS.torque.cells_of_position * THRESHOLDS.torque.cells_of_speed
    seen = np.concatenate([c[rows] for c, rows in zip(cells, model.study.fitted_rows, strict=True)])
    sums = np.bincount(seen, model.fitted, minlength=count)
    table = sums / np.maximum(np.bincount(seen, minlength=count), 1)
    unseen = np.concatenate([c[rows] for c, rows in zip(cells, model.study.unseen_rows, strict=True)])
    return min(rms(model.unseen - table[unseen]), _polynomials_rms(model))


def _polynomials_rms(model: TorqueFit) -> float:
    """Return the RMS that a polynomial of the position for each direction of motion leaves on held-out rows."""
    motion = np.concatenate([measured_motion(run) for run in model.study.runs])
    seen, unseen = np.concatenate(model.study.fitted_rows), np.concatenate(model.study.unseen_rows)
    residual = np.concatenate(model.residual)
    middle, half = 0.5 * (motion[:, 0].max() + motion[:, 0].min()), max(0.5 * float(np.ptp(motion[:, 0])), 1e-12)
    columns = np.polynomial.chebyshev.chebvander((motion[:, 0] - middle) / half, THRESHOLDS.torque.degree_of_black_box)
    predicted = np.zeros(residual.size)
    for direction in (motion[:, 1] > 0, motion[:, 1] <= 0):
        learned = np.linalg.lstsq(columns[direction & seen], residual[direction & seen], rcond=None)[0]
        predicted[direction] = columns[direction] @ learned
    return rms(residual[unseen] - predicted[unseen])


def _cells(model: TorqueFit) -> list[Cells]:
    """Return the number of the cell of every row of every run; cells of speed hold equally many rows."""
    limits = THRESHOLDS.torque
    motions = [measured_motion(run) for run in model.study.runs]
    q: Array = np.concatenate([m[:, 0] for m in motions])
    v: Array = np.concatenate([m[:, 1] for m in motions])
    places = np.linspace(q.min(), q.max(), limits.cells_of_position + 1)[1:-1]
    speeds = np.quantile(v, np.linspace(0.0, 1.0, limits.cells_of_speed + 1)[1:-1])
    return [np.digitize(m[:, 0], places) * limits.cells_of_speed + np.digitize(m[:, 1], speeds) for m in motions]
