"""Merge rows of long recordings: a `Study` in, the same study with one row in the place of several out.

A search costs as much as it has rows: signatures of the whole catalogue are kept for every reading. A device that is
recorded at 2 kHz says no more of its friction than at 400 Hz, as long as its torque hardly changes in between.

Of every n rows the first reading is kept. Between two readings that are kept the torque w is linear, and its double
integral is that of the recording at every one of them,

    ∬ w dt² = ∬ u dt² ,

so that w is the second derivative of the cubic spline through ∬ u dt²: a joint without friction or springs moves to the
same readings. What is lost for any other is found out by simulation: where it shows in the readings, fewer rows are
merged (`discrepancy.search.nominal_model`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import rms


def merged(study: Study, every: int) -> Study:
    """Return the study with one row in the place of ``every``.

    Parameters
    ----------
    study
        Study of one joint or several, with all its rows.
    every
        Number of rows that one stands for, at least 1.

    Returns
    -------
    Study
        The study as it is where ``every`` is 1.
    """
    if every == 1:
        return study
    fitted, unseen, sealed = (
        tuple(merge_rows(run, every) for run in runs) for runs in (study.fitted, study.unseen, study.sealed)
    )
    return replace(study, fitted=fitted, unseen=unseen, sealed=sealed, rows_merged=every)


def rows_to_merge(study: Study) -> int:
    """Return how many rows may be merged into one, by the number of rows and by what the torque does between them.

    Parameters
    ----------
    study
        Study with all its rows.

    Returns
    -------
    int
        1 where the fitted runs have at most `most_rows_searched` rows. Else as many as bring them there, but not more
        than lie within the inner step `coarse_step_s`, and not so many that the torque changes within them by more than
        `largest_torque_change_within_merged_rows`. 1 for runs whose input is not a torque, and for readings that the
        recorder averaged: a mean over other rows would not be what it averaged.
    """
    rows = sum(run.t.size - run.score_from for run in study.fitted)
    runs = (*study.fitted, *study.unseen, *study.sealed)
    if rows <= THRESHOLDS.study.most_rows_searched or not all(map(_can_be_merged, runs)):
        return 1
    spacing = max(float(np.median(np.diff(run.t))) for run in runs)
    longest = int(THRESHOLDS.study.coarse_step_s / spacing + 1e-6)
    every = min(-(-rows // THRESHOLDS.study.most_rows_searched), longest)
    while every > 1 and _largest_change(runs, every) > THRESHOLDS.study.largest_torque_change_within_merged_rows:
        every -= 1
    return max(every, 1)


def _can_be_merged(run: Run) -> bool:
    """Say whether a run's input is its torque, and its readings are those of a moment."""
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
        score_from=-(-run.score_from // every),
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


def _largest_change(runs: Sequence[Run], every: int) -> float:
    """Return the largest RMS, over the runs' joints, of u − w over that of u − its mean."""
    changes = [0.0]
    for run in runs:
        few = merge_rows(run, every)
        for k in range(run.u.shape[1]):
            size = float(np.std(run.u[:, k]))
            change = rms(run.u[:, k] - np.interp(run.t, few.t, few.u[:, k]))
            changes.append(change / size if size > 0.0 else 0.0)
    return max(changes)
