"""What a device says of its joints that measured numbers can be held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.reader import load_device


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Largest torque (force) of a joint [N m] ([N]) and its range of motion [rad] ([m]), infinite where not stated."""

    torque: float = np.inf
    travel: float = np.inf


def limits_of(campaign: Campaign) -> dict[int, Limits]:
    """Return the limits of the device's joints by number; none for ``single_joint``."""
    if campaign.device == SINGLE_JOINT:
        return {}
    limits = {}
    for number, joint in enumerate(load_device(campaign.device, campaign.folder).joints):
        lower, upper = joint.position_limits
        stated = (lower, upper) != (-np.pi, np.pi)  # what a device has that says nothing: such a joint may turn on
        limits[number] = Limits(torque=joint.torque_limit, travel=upper - lower if stated else np.inf)
    return limits
