"""Postures of the locked joints: runs in, runs whose postures compare equal where they are one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run


def locked_posture(run: Run) -> tuple[float, ...]:
    """Return the posture of the locked joints, with free joints at 0, so that runs in one posture compare equal.

    Parameters
    ----------
    run
        Run with its posture.

    Returns
    -------
    tuple of float
        Position of every joint of the device [rad] ([m]).
    """
    return tuple(0.0 if j in run.free_joints else float(x) for j, x in enumerate(run.posture))


def join_postures(runs: Sequence[Run]) -> tuple[Run, ...]:
    """Give runs of the same free joints one posture where their postures differ by no more than readings do.

    Each run of a logger that also records the held joints has readings of its own for the same lock.

    Parameters
    ----------
    runs
        Runs of a campaign, whatever their use; a stated encoder step is taken from the runs that free the joint.

    Returns
    -------
    tuple of Run
        The same runs in the same order. Only postures change: to the median over the runs in that posture.
    """
    steps = stated_steps(runs)
    held = [np.array(locked_posture(run)) for run in runs]
    joined = median_postures([run.free_joints for run in runs], held, steps)
    changed = []
    for run, before, after in zip(runs, held, joined, strict=True):
        if np.array_equal(before, after):
            changed.append(run)
            continue
        # The entries of free joints are ignored everywhere, and stay as they were written.
        free = np.isin(np.arange(run.posture.size), run.free_joints)
        changed.append(run.but(posture=np.where(free, run.posture, after)))
    return tuple(changed)


def stated_steps(runs: Sequence[Run]) -> dict[int, float]:
    """Return the stated encoder steps of the joints.

    Parameters
    ----------
    runs
        Runs of a campaign.

    Returns
    -------
    dict
        Largest step [rad] ([m]) by joint; joints without a stated one are missing.
    """
    steps: dict[int, float] = {}
    for run in runs:
        for joint, step in zip(run.free_joints, run.resolution, strict=True):
            if np.isfinite(step):
                steps[joint] = max(float(step), steps.get(joint, 0.0))
    return steps


def median_postures(
    free_joints: Sequence[tuple[int, ...]], postures: Sequence[Array], steps: dict[int, float]
) -> list[Array]:
    """Replace the postures that are one by their median.

    Parameters
    ----------
    free_joints
        Free joints of each run.
    postures
        Positions of all joints in each run [rad] ([m]), shape (n_joints,) each, 0 for the free ones.
    steps
        Encoder steps by joint, as far as they are known.

    Returns
    -------
    list of ndarray
        A posture for each run: the median of the runs with the same free joints and no position further from that of
        the group than `largest_difference_of_one_posture`, or the encoder's step.
    """
    groups: list[list[int]] = []
    for k, posture in enumerate(postures):
        for group in groups:
            middle = np.median([postures[other] for other in group], axis=0)
            alike = free_joints[group[0]] == free_joints[k] and middle.shape == posture.shape
            if alike and np.all(np.abs(posture - middle) <= _tolerances(posture.size, steps)):
                group.append(k)
                break
        else:
            groups.append([k])
    joined = list(postures)
    for group in groups:
        middle = np.median([postures[k] for k in group], axis=0)
        for k in group:
            joined[k] = middle
    return joined


def _tolerances(joints: int, steps: dict[int, float]) -> Array:
    """Return by how much a position may differ within a posture: the median of readings may be one step off."""
    least = THRESHOLDS.largest_difference_of_one_posture
    margin = 1.0 + 1e-9  # a difference of one step, as numbers have it
    return np.array([max(least, margin * steps.get(joint, 0.0)) for joint in range(joints)])
