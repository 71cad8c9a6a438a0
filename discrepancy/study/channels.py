"""Rows of a residual by run and joint: what is joint after joint in one reading, and reading after reading in a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from haptid.measurement.values.run import Run


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """One joint of a run.

    Parameters
    ----------
    run
        The run as one of this joint alone.
    number
        Which of the runs it is from.
    column
        Which of the run's joints it is.
    rows
        Where its residuals lie among those of all runs.
    """

    run: Run
    number: int
    column: int
    rows: slice


def channels(runs: Sequence[Run]) -> tuple[Channel, ...]:
    """Return the channels of all runs, run by run."""
    found, first = [], 0
    for number, run in enumerate(runs):
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
    """Return a run with one of its joints only: the same one where it has no other, and every time it is asked for."""
    if run.y.shape[1] == 1:
        return run
    one = slice(column, column + 1)
    return run.but(
        free_joints=run.free_joints[one], u=run.u[:, one], y=run.y[:, one], v=None if run.v is None else run.v[:, one],
        noise=run.noise[one], resolution=run.resolution[one], prismatic=run.prismatic[one],
    )  # fmt: skip


def scored_rows(run: Run) -> int:
    """Count the residuals of a run that are scored, those of all its joints."""
    return (run.t.size - run.score_from) * run.y.shape[1]
