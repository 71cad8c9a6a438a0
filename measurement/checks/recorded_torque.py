"""Take recorded torques in the place of a stated controller that did not make them: `Campaign` in, `Campaign` out.

A joint with a stated controller is simulated through it. Where the torque was recorded as well and is another one (the
firmware filters its speed, or acts a row late), a simulation through the stated law puts its error into inertia and
friction, while the recorded torque is what moved the joint.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.remarks.stated_controller import difference_from_recorded, with_recorded_torques
from haptid.measurement.remarks.torque_sign import share_left
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign


def with_torques_that_were(campaign: Campaign) -> Campaign:
    """Leave out stated controllers whose torque is not the recorded one, and take that.

    Parameters
    ----------
    campaign
        As it was read.

    Returns
    -------
    Campaign
        The same but for joints whose recorded torque differs from the stated law's by more than
        `largest_difference_of_stated_controller`, unless it is the noisier of the two: their runs hold the recorded
        torque and they have no drive. A remark names each of them.
    """
    recorded = with_recorded_torques(campaign)
    for joint in campaign.drives:
        differences = [difference_from_recorded(run, campaign) for run in campaign.runs_of((joint,))]
        known = [one for one in differences if one is not None]
        if not known or len(known) < len(differences):
            continue
        size = float(np.sqrt(np.mean(np.square(known))))
        if size > THRESHOLDS.largest_difference_of_stated_controller and not _is_noisier(campaign, recorded, joint):
            campaign = _without_controller(campaign, recorded, joint, size)
    return campaign


def _is_noisier(campaign: Campaign, recorded: Campaign, joint: int) -> bool:
    """Say whether a rigid body explains the stated controller's torque far better than the recorded one.

    True also where no fitted run is long enough to tell: then the stated law stays.
    """
    of_law, of_record = (
        [run for run in one.runs_of((joint,), "fit") if run.t.size >= THRESHOLDS.least_differences_of_noise]
        for one in (campaign, recorded)
    )
    if not of_law:
        return True
    theirs, ours = share_left(of_record), share_left(of_law)
    return theirs > THRESHOLDS.least_share_left_by_noisy_torque * ours


def _without_controller(campaign: Campaign, recorded: Campaign, joint: int, size: float) -> Campaign:
    runs = tuple(
        measured.but(drive_inputs={}) if run.free_joints == (joint,) else run
        for run, measured in zip(campaign.runs, recorded.runs, strict=True)
    )
    remark = (
        f"joint {joint}: the torque of the stated controller is {100 * size:.2g} % (RMS) off the recorded one: "
        "the recorded torque is used, and the controller left out"
    )
    drives = {other: drive for other, drive in campaign.drives.items() if other != joint}
    return campaign.but(runs=runs, drives=drives, remarks=(*campaign.remarks, remark))
