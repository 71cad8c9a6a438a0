"""Lay out the residual rows of several runs by run and joint: `Run`s in, `Channel`s out.

The residual vector stacks the runs one after another. Within a run it stacks the rows in time, and within a row the
joints: the residual of joint k at row i of a run of n joints has the index first + i·n + k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from haptid.measurement.values.run import Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One joint of one run, with the place of its residuals in the stacked residual vector.

    Parameters
    ----------
    run
        The run reduced to this joint.
    number
        Index of the run in the sequence of runs.
    column
        Index of the joint among the free joints of the run.
    rows
        Slice of the stacked residual vector that holds this joint's residuals; its step is the number of joints.
    """

    run: Run
    number: int
    column: int
    rows: slice


def channels(runs: Sequence[Run]) -> tuple[Channel, ...]:
    """Return one channel for every joint of every run.

    Parameters
    ----------
    runs
        Runs in the order in which their residuals are stacked.

    Returns
    -------
    tuple of Channel
        Channels run by run, and joint by joint within a run.
    """
    found, first = [], 0
    for number, run in enumerate(runs):
        # A row holds all joints of one sample, so one joint's residuals lie ``joints`` apart.
        joints = run.y.shape[1]
        end = first + run.y.size
        found += [
            Channel(run=alone(run, k), number=number, column=k, rows=slice(first + k, end, joints))
            for k in range(joints)
        ]
        first = end
    return tuple(found)


@lru_cache(maxsize=64)
def alone(run: Run, column: int) -> Run:
    """Reduce a run to one of its joints.

    Parameters
    ----------
    run
        Run of one or several free joints.
    column
        Index of the joint among the free joints of the run.

    Returns
    -------
    Run
        Run whose arrays have one column. A run of one joint is returned as it is, and repeated calls return the same
        object, so that caches keyed by the run keep working.
    """
    if run.y.shape[1] == 1:
        return run
    one = slice(column, column + 1)
    return run.but(
        free_joints=run.free_joints[one], u=run.u[:, one], y=run.y[:, one], v=None if run.v is None else run.v[:, one],
        noise=run.noise[one], resolution=run.resolution[one], prismatic=run.prismatic[one],
    )  # fmt: skip


def scored_rows(run: Run) -> int:
    """Count the scored residuals of a run: its rows from ``score_from`` on, times its joints.

    Parameters
    ----------
    run
        Run of one or several free joints.

    Returns
    -------
    int
        Number of residuals.
    """
    return (run.t.size - run.score_from) * run.y.shape[1]
