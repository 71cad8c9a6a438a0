"""Merge rows of a long recording: a `Run` in, the same run with one row in the place of several out.

A device that is recorded at 2 kHz says no more of its friction than at 400 Hz, as long as its torque hardly changes in
between, and costs five times as much.

Of every n rows the first reading is kept. Between two readings that are kept the torque w is linear, and its double
integral is that of the recording at every one of them,

    ∬ w dt² = ∬ u dt² ,

so that w is the second derivative of the cubic spline through ∬ u dt²: a joint without friction or springs moves to the
same readings. What is lost for any other is found out by simulation, by those who merge.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import rms


def can_be_merged(run: Run) -> bool:
    """Say whether a run's input is its torque, and its readings are those of a moment.

    Parameters
    ----------
    run
        Run of one joint or several.

    Returns
    -------
    bool
        False for readings that the recorder averaged: a mean over other rows would not be what it averaged.
    """
    return not run.drive_inputs and run.averaged_rows == 1


def merge_rows(run: Run, every: int) -> Run:
    """Return a run with one row in the place of ``every``.

    Parameters
    ----------
    run
        Run of n_t rows, driven by torques.
    every
        Number of rows that one stands for.

    Returns
    -------
    Run
        Run of ⌈n_t/``every``⌉ rows with the torques of `spline_torques`, linear between rows. Positions, velocities and
        further columns are those of the first row of each group. The first scored row is the first one that is kept
        at or after ``score_from``.
    """
    kept = slice(0, None, every)
    return run.but(
        t=run.t[kept], u=spline_torques(run, every), y=run.y[kept], v=None if run.v is None else run.v[kept],
        hold="linear", extra={name: column[kept] for name, column in run.extra.items()},
        score_from=-(-run.score_from // every), weight=run.weight[kept],
    )  # fmt: skip


def spline_torques(run: Run, every: int) -> Array:
    """Return the torques at the kept rows whose linear course has the double integral of the recorded ones.

    Parameters
    ----------
    run
        Run whose torque is held or interpolated between rows.
    every
        Number of rows that one stands for.

    Returns
    -------
    ndarray
        Torques w [N m], shape (⌈n_t/``every``⌉, n_joints).
    """
    dt, u = np.diff(run.t)[:, None], run.u[:-1]
    after = u if run.hold == "zero" else run.u[1:]
    speed = np.vstack([np.zeros((1, u.shape[1])), np.cumsum(0.5 * (u + after) * dt, axis=0)])
    steps = speed[:-1] * dt + (2.0 * u + after) * dt**2 / 6.0
    travel = np.vstack([np.zeros((1, u.shape[1])), np.cumsum(steps, axis=0)])
    kept = slice(0, None, every)
    t, first, last = run.t[kept], speed[kept][0], speed[kept][-1]
    return np.asarray(CubicSpline(t, travel[kept], bc_type=((1, first), (1, last)))(t, 2))


def largest_change(runs: Sequence[Run], every: int) -> float:
    """Return the largest RMS, over the runs' joints, of u − w over that of u − its mean.

    Parameters
    ----------
    runs
        Runs driven by torques.
    every
        Number of rows that one stands for.

    Returns
    -------
    float
        Share of the torque that its linear course loses [1].
    """
    changes = [0.0]
    for run in runs:
        few = merge_rows(run, every)
        for k in range(run.u.shape[1]):
            size = float(np.std(run.u[:, k]))
            change = rms(run.u[:, k] - np.interp(run.t, few.t, few.u[:, k]))
            changes.append(change / size if size > 0.0 else 0.0)
    return max(changes)
