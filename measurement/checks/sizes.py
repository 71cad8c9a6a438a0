"""Check the size of measured numbers: `Campaign` in and out, refused where fits would overflow."""

from __future__ import annotations

import numpy as np

from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError


def check_sizes(campaign: Campaign) -> Campaign:
    """Refuse a campaign where no sensor can have measured a number.

    Parameters
    ----------
    campaign
        As it was read; excluded runs are not checked.

    Returns
    -------
    Campaign
        The same, unchanged.

    Raises
    ------
    InputError
        With the table and the joint whose torque, position or velocity is too large, or whose torque is too small.
    """
    for run in campaign.runs:
        if run.use != "excluded":
            for column in range(len(run.free_joints)):
                _check(run, column, f"{campaign.folder / run.file}, joint {run.free_joints[column]}")
    return campaign


def _check(run: Run, column: int, where: str) -> None:
    unit = "m" if run.prismatic[column] else "rad"
    torque = "N" if run.prismatic[column] else "N m"
    _check_size(
        run.u[:, column], THRESHOLDS.largest_torque, f"a torque up to {THRESHOLDS.largest_torque:g} {torque}", where
    )
    _check_size(
        run.y[:, column], THRESHOLDS.largest_position, f"a position up to {THRESHOLDS.largest_position:g} {unit}", where
    )
    if run.v is not None:
        _check_size(
            run.v[:, column], THRESHOLDS.largest_speed, f"a velocity up to {THRESHOLDS.largest_speed:g} {unit}/s", where
        )
    most = float(np.abs(run.u[:, column]).max())
    if 0 < most < THRESHOLDS.smallest_torque:
        expected, todo = f"a torque of {THRESHOLDS.smallest_torque:g} {torque} at least", "check its unit"
        raise InputError(where, expected=expected, got=f"{most:.3g} at most", todo=todo)


def _check_size(values: Array, most: float, expected: str, where: str) -> None:
    largest = float(np.abs(values).max())
    if largest > most:
        raise InputError(where, expected=expected, got=f"{largest:.3g}", todo="check its unit")
