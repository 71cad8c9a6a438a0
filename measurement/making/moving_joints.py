"""Joints that move in a table: columns of the campaign format in, joint numbers out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def moving_joints(t: Array, positions: Mapping[str, Array], joints: Sequence[int]) -> tuple[int, ...]:
    """Return the joints that move: a logger records also those that are locked.

    A joint moves where its travel is above its noise, and above a small share of the largest travel in the table.

    Parameters
    ----------
    t
        Times [s], shape (n_t,).
    positions
        Readings [rad] ([m]) by the column's name, as ``position_0_rad``, each of shape (n_t,).
    joints
        Numbers of the joints that have a torque and a position.

    Returns
    -------
    tuple of int
        All of ``joints`` where only one is there, or none moves.
    """
    if len(joints) == 1:
        return tuple(joints)
    travels = {
        joint: float(np.ptp(positions[name]))
        for joint in joints
        for name in (f"position_{joint}_rad", f"position_{joint}_m")
        if name in positions and not _rests(t, positions[name])
    }
    slides = {joint: f"position_{joint}_m" in positions for joint in joints}
    found = []
    for joint, travel in travels.items():
        largest = max(other for j, other in travels.items() if slides[j] == slides[joint])
        if travel >= THRESHOLDS.least_travel_over_largest * largest:
            found.append(joint)
    return tuple(sorted(found)) or tuple(joints)


def _rests(t: Array, y: Array) -> bool:
    step = estimate_resolution(y)
    noise = float(np.hypot(estimate_noise(t, y, step), step / np.sqrt(12.0)))
    return float(np.ptp(y)) < THRESHOLDS.least_travel_over_noise * noise
