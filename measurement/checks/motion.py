"""Refuse a campaign with a configuration at rest, from which nothing is identifiable: `Campaign` in and out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.measurement.signals.noise import with_noise
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.postures import locked_posture
from haptid.measurement.values.run import Array, Run
from haptid.support.errors import InputError


def check_motion(campaign: Campaign, prepared: Campaign) -> Campaign:
    """Return the prepared campaign, or refuse it where a configuration to fit does not move.

    Parameters
    ----------
    campaign
        As it was read, with NaN where no noise is stated: the error says whether the noise was stated or estimated.
    prepared
        The same campaign with noise filled in and runs held out.

    Returns
    -------
    Campaign
        ``prepared``.

    Raises
    ------
    InputError
        Where all joints of a configuration travel less than 10 times the noise in all its runs to fit.
    """
    stated = {run.file: run for run in campaign.runs}
    groups: dict[tuple[tuple[int, ...], tuple[float, ...]], list[Run]] = {}
    for run in prepared.runs:
        if run.use == "fit":
            groups.setdefault((run.free_joints, locked_posture(run)), []).append(run)
    for runs in groups.values():
        if all(np.all(_travel(run) < THRESHOLDS.least_travel_over_noise * run.sensor_std) for run in runs):
            raise _at_rest(campaign, runs, [stated[run.file] for run in runs])
    return prepared


def in_first_postures(campaign: Campaign) -> Campaign:
    """Keep the runs of each set of free joints that were recorded in its first lock posture.

    Coefficients differ between postures: what studies the runs of one equation takes those of one posture.

    Parameters
    ----------
    campaign
        Campaign whose runs may be of several postures.

    Returns
    -------
    Campaign
        The posture of a set is that of its first run to fit; sets without one keep all their runs.
    """
    first: dict[tuple[int, ...], tuple[float, ...]] = {}
    for run in campaign.runs:
        if run.use == "fit":
            first.setdefault(run.free_joints, locked_posture(run))
    kept = [run for run in campaign.runs if locked_posture(run) == first.get(run.free_joints, locked_posture(run))]
    return campaign.but(runs=tuple(kept))


def _travel(run: Run) -> Array:
    return np.asarray(np.ptp(run.y, axis=0))


def _at_rest(campaign: Campaign, runs: Sequence[Run], stated: Sequence[Run]) -> InputError:
    """Return the error with its remedy: correct the stated noise where the rows show less, else measure again."""
    first = runs[0]
    joints = ", ".join(map(str, first.free_joints))
    travel, noise = max(float(_travel(run).max()) for run in runs), float(first.sensor_std.max())
    unstated = [run.but(noise=np.full(run.noise.shape, np.nan), resolution=run.noise * np.nan) for run in stated]
    moves = any(
        np.any(_travel(run) >= THRESHOLDS.least_travel_over_noise * with_noise(run).sensor_std) for run in unstated
    )
    told = bool(np.isfinite(stated[0].noise).any() or np.isfinite(stated[0].resolution).any())
    todo = "measure with more torque, or set these runs to excluded"
    if told and moves:
        todo = "correct noise or resolution under [sensor] in campaign.toml: the rows show less"
    least = f"{THRESHOLDS.least_travel_over_noise:.0f}"
    expected = f"a run in which joint {joints} moves more than {least} times the sensor's noise"
    got = f"a travel of {travel:.3g} at most, noise {noise:.3g} ({'stated' if told else 'estimated'})"
    return InputError(str(campaign.folder / first.file), expected=expected, got=got, todo=todo)
