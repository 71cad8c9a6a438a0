"""Limits that a device states of its joints, for comparison with measured numbers: `Campaign` in, `Limits` out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Hold the limits of one joint, infinite where the device does not state them.

    Parameters
    ----------
    torque
        Largest torque (force) [N m] ([N]).
    travel
        Range of motion, upper minus lower limit [rad] ([m]).
    """

    torque: float = np.inf
    travel: float = np.inf


def limits_of(campaign: Campaign) -> dict[int, Limits]:
    """Take the limits of the joints from the device of a campaign.

    Parameters
    ----------
    campaign
        Campaign that names the device.

    Returns
    -------
    dict
        `Limits` by joint number; empty for ``single_joint``.

    Raises
    ------
    InputError
        Where the file of the device is at fault.
    """
    device = device_of(campaign)
    if device is None:
        return {}
    limits = {}
    for number, joint in enumerate(device.joints):
        lower, upper = joint.position_limits
        stated = (lower, upper) != (-np.pi, np.pi)  # the default of a device without limits: the joint may turn on
        limits[number] = Limits(torque=joint.torque_limit, travel=upper - lower if stated else np.inf)
    return limits
