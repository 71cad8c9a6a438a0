"""Compare torque with the stated inertia: `Campaign` in, a sentence by file out where their scales disagree.

Rows alone determine torque up to a factor; the inertia that the campaign or its device states fixes it.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.format.devices import device_of
from haptid.measurement.signals.smoothing import smooth
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.device.stated_parameters import stated_value
from haptid.model.joint.coupled_joints import configuration_equations


def off_scale(campaign: Campaign) -> dict[str, str]:
    """Find joints whose torque contradicts their stated inertia.

    Parameters
    ----------
    campaign
        As it was read; excluded and coupled runs are ignored.

    Returns
    -------
    dict
        A sentence by file, for the fastest run of each such joint: the one with the least torque per acceleration.

    Raises
    ------
    InputError
        Where the file of the device is at fault.

    Notes
    -----
    Compares Kp·σ(τ)/σ(q̈) with the stated inertia; σ is the standard deviation of the smoothed signals (`smooth`).
    """
    found = {}
    for joint in campaign.joints:
        runs = [run for run in campaign.runs_of((joint,)) if run.use != "excluded" and np.ptp(run.y) > 0]
        inertia, gain = _find_stated_inertia(campaign, joint)
        if not runs or inertia is None:
            continue
        shown = {run.file: gain * _torque_per_acceleration(run) for run in runs}
        file = min(shown, key=lambda name: shown[name])
        remedy = "are torque and position in other units than the columns' names say?"
        if shown[file] > THRESHOLDS.largest_torque_over_inertial_torque * inertia:
            remedy = "is the torque in thousandths of its unit? then multiply by 0.001"
        elif shown[file] == 0 or shown[file] > inertia / THRESHOLDS.largest_torque_over_inertial_torque:
            continue
        found[file] = (
            f"torque over acceleration is {shown[file]:.2g} in the joint's fastest run, "
            f"{shown[file] / inertia:.2g} times the stated inertia of {inertia:.2g}: {remedy}"
        )
    return found


def _torque_per_acceleration(run: Run) -> float:
    motion = smooth(run)
    acceleration = float(np.std(motion.a))
    return float(np.std(motion.torque)) / acceleration if acceleration > 0 else 0.0


def _find_stated_inertia(campaign: Campaign, joint: int) -> tuple[float | None, float]:
    """Return the inertia that is stated of a joint (None where nothing is), and Kp."""
    given = campaign.parameter_overrides.get(joint, {})
    gain = stated_value(given.get("Kp", {})) or 1.0
    inertia = stated_value(given.get("inertia", {}))
    device = device_of(campaign) if inertia is None else None
    if device is not None:
        posture = tuple(float(x) for x in campaign.runs_of((joint,))[0].posture)
        parameters = configuration_equations(device, (joint,), posture).parameters
        inertia = next((q.initial for q in parameters if q.id == "inertia"), None)
    return inertia, gain
