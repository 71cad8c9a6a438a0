"""What of a residual torque repeats: `TorqueFit` in, floor and black box out.

The floor is what differs between passes of one cell of position and speed (`measurement.signals.repeats`). A *black
box* holds all that is bound to position and speed, without physics: the table of the cells' mean residual on fitted
rows, or a polynomial of the position for each direction of motion. What the better of them leaves on held-out rows is
the aim of named effects.
"""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, rms
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.signals import repeats


def floor_of(model: TorqueFit) -> float | None:
    """Estimate the RMS of the residual torque that does not repeat.

    Parameters
    ----------
    model
        Fitted model; its residual holds what repeats as well.

    Returns
    -------
    float or None
        RMS [N m], or [N] of a prismatic joint; None where too few rows are passed again.
    """
    rows = list(zip(_cells(model), model.residual, model.study.moving, strict=True))
    return repeats.floor_of([cells[moving] for cells, _, moving in rows], [left[moving] for _, left, moving in rows])


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
    cells, count = _cells(model), repeats.cell_count()
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


def _cells(model: TorqueFit) -> list[repeats.Cells]:
    motions = [measured_motion(run) for run in model.study.runs]
    return repeats.cells_of([m[:, 0] for m in motions], [m[:, 1] for m in motions])
