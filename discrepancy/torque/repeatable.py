"""What of a residual torque repeats: `TorqueFit` in, floor and black box out.

The floor is what differs between passes of one cell of position and speed (`measurement.signals.repeats`). A *black
box* holds all that is bound to position and speed, without physics: the table of the cells' mean residual on fitted
rows, coarse or fine, or a polynomial of the position for each direction of motion. What the best of them leaves on
held-out rows is the aim of named effects. Both are those of rows away from reversals, which name effects.
"""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.signals import repeats
from haptid.measurement.thresholds import THRESHOLDS as THRESHOLDS_OF_CELLS
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import rms


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
    return repeats.lowest_floor(*_motion(model), model.residual, model.study.naming_rows(model.study.moving))


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
    tables = [_table_rms(model, fineness) for fineness in THRESHOLDS_OF_CELLS.fineness_of_cells]
    return min(*tables, _polynomials_rms(model))


def _table_rms(model: TorqueFit, fineness: int) -> float:
    """Return the RMS that the mean residual of each cell leaves on held-out rows."""
    cells, count = repeats.cells_of(*_motion(model), fineness), repeats.cell_count(fineness)
    seen = np.concatenate([c[rows] for c, rows in zip(cells, model.study.fitted_rows, strict=True)])
    sums = np.bincount(seen, model.fitted, minlength=count)
    table = sums / np.maximum(np.bincount(seen, minlength=count), 1)
    unseen = np.concatenate([c[rows] for c, rows in zip(cells, model.study.unseen_rows, strict=True)])
    return rms((model.unseen - table[unseen])[model.study.names(model.study.unseen_rows)])


def _polynomials_rms(model: TorqueFit) -> float:
    """Return the RMS that a polynomial of the position for each direction of motion leaves on held-out rows."""
    motion = np.concatenate([measured_motion(run) for run in model.study.runs])
    seen = np.concatenate(model.study.fitted_rows)
    unseen = np.concatenate(model.study.naming_rows(model.study.unseen_rows))
    residual = np.concatenate(model.residual)
    middle, half = 0.5 * (motion[:, 0].max() + motion[:, 0].min()), max(0.5 * float(np.ptp(motion[:, 0])), 1e-12)
    columns = np.polynomial.chebyshev.chebvander((motion[:, 0] - middle) / half, THRESHOLDS.torque.degree_of_black_box)
    predicted = np.zeros(residual.size)
    for direction in (motion[:, 1] > 0, motion[:, 1] <= 0):
        learned = np.linalg.lstsq(columns[direction & seen], residual[direction & seen], rcond=None)[0]
        predicted[direction] = columns[direction] @ learned
    return rms(residual[unseen] - predicted[unseen])


def _motion(model: TorqueFit) -> tuple[list[Array], list[Array]]:
    """Return measured position and speed by run."""
    motions = [measured_motion(run) for run in model.study.runs]
    return [m[:, 0] for m in motions], [m[:, 1] for m in motions]
