"""Parameters of several devices compared: identification results in, `Comparison`s out.

The spread between devices is robust: 1.4826 times the median absolute deviation from the median, which is the standard
deviation of normal values and is moved little by a device that deviates. Source: Iglewicz and Hoaglin, How to detect
and handle outliers (1993). How large a robust z equal devices reach is simulated: with few devices it is large.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from haptid.identification.thresholds import THRESHOLDS

FEWEST_DEVICES = 4
"""Devices below which a median absolute deviation says nothing of the one that deviates."""
CHANCE = 0.05
"""Probability that a fleet of equal devices has any parameter told as deviating [1]."""
DRAWS = 40_000
STD_PER_MAD = 1.4826


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A parameter of one device.

    Parameters
    ----------
    device
        Name of the device.
    value, std
        Estimate and its standard deviation, in the parameter's unit.
    lower, upper
        Ends of the 95 % interval: the profile likelihood's where it was followed, else value ± 1.96 std.
    status
        Status that the identification gave.
    z
        Robust z; None where the parameter is not identified in this device or the fleet is too small.
    deviates
        Whether |z| is beyond the limit.
    """

    device: str
    value: float
    std: float
    lower: float
    upper: float
    status: str
    z: float | None = None
    deviates: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A parameter over all devices.

    Parameters
    ----------
    configuration
        Free joints and posture in words, as in ``joint 4``.
    parameter, unit
        Id and unit.
    median, spread
        Of the devices in which it is identified; None where they are fewer than `FEWEST_DEVICES`.
    limit
        |z| from which a device deviates; None where nothing is judged.
    members
        One per device that has the parameter.
    """

    configuration: str
    parameter: str
    unit: str
    median: float | None
    spread: float | None
    limit: float | None
    members: tuple[Member, ...]


@cache
def largest_z_by_chance(devices: int, comparisons: int) -> float:
    """Simulate the |z| that any of equal devices exceeds in any of several parameters with probability `CHANCE`.

    Parameters
    ----------
    devices
        Number of devices.
    comparisons
        Number of parameters; each gets an equal part of the probability.

    Returns
    -------
    float
        Quantile 1 − `CHANCE`/comparisons of the largest robust |z| of normal values [1], at most that of `DRAWS` draws.
    """
    values = np.random.default_rng(0).standard_normal((DRAWS, devices))
    centred = values - np.median(values, axis=1, keepdims=True)
    spread = STD_PER_MAD * np.median(np.abs(centred), axis=1)
    largest = np.max(np.abs(centred), axis=1) / spread
    # The tail beyond the last draws is not known: then the largest draw is the limit.
    return float(np.quantile(largest, 1 - CHANCE / comparisons))


def compare(results: Mapping[str, Mapping[str, Any]]) -> tuple[Comparison, ...]:
    """Compare the parameters of devices.

    Parameters
    ----------
    results
        Content of identification.json by the name of the device.

    Returns
    -------
    tuple of Comparison
        Every parameter that at least one device has, in the order of the first device that has it.
    """
    rows: dict[tuple[str, str, str], list[Member]] = {}
    for device, result in results.items():
        for entry in result["configurations"]:
            for id, parameter in entry["parameters"].items():
                key = (_configuration(entry), id, parameter.get("unit", ""))
                rows.setdefault(key, []).append(_member(device, parameter))
    judged = sum(len(_keep_identified(members)) >= FEWEST_DEVICES for members in rows.values())
    return tuple(_judge(key, members, judged) for key, members in rows.items())


def _configuration(entry: Mapping[str, Any]) -> str:
    joints = entry.get("free_joints", [])
    name = "joint" + "s" * (len(joints) > 1) + " " + "+".join(map(str, joints)) if joints else "model"
    posture = entry.get("locked_positions_rad") or []
    locked = [round(x, 4) for joint, x in enumerate(posture) if joint not in joints]
    return f"{name} at {locked}" if any(locked) else name


def _member(device: str, parameter: Mapping[str, Any]) -> Member:
    value, std = float(parameter["value"]), float(parameter["std"] or 0.0)
    ends = parameter.get("profile_95") or [None, None]
    reach = THRESHOLDS.standard_errors_of_interval * std
    lower = value - reach if ends[0] is None else ends[0]
    upper = value + reach if ends[1] is None else ends[1]
    return Member(device=device, value=value, std=std, lower=lower, upper=upper, status=parameter["status"])


def _keep_identified(members: Sequence[Member]) -> list[Member]:
    return [member for member in members if member.status == "identified"]


def _judge(key: tuple[str, str, str], members: Sequence[Member], judged: int) -> Comparison:
    configuration, parameter, unit = key
    known = _keep_identified(members)
    if len(known) < FEWEST_DEVICES:
        return Comparison(
            configuration=configuration, parameter=parameter, unit=unit, median=None, spread=None, limit=None,
            members=tuple(members),
        )  # fmt: skip
    values = np.array([member.value for member in known])
    median = float(np.median(values))
    spread = STD_PER_MAD * float(np.median(np.abs(values - median)))
    limit = largest_z_by_chance(len(known), judged)
    return Comparison(
        configuration=configuration, parameter=parameter, unit=unit, median=median, spread=spread, limit=limit,
        members=tuple(_with_z(member, median, spread, limit) for member in members),
    )  # fmt: skip


def _with_z(member: Member, median: float, spread: float, limit: float) -> Member:
    scale = float(np.hypot(spread, member.std))
    if member.status != "identified" or scale == 0.0:
        return member
    z = (member.value - median) / scale
    return replace(member, z=z, deviates=abs(z) > limit)
