"""The embedded six-joint device, identified: its values, its equations, and the runs with all joints free."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from haptid.api.campaign import Campaign
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.whole_device import full_equations

STORED = Path(__file__).parents[2] / "docs" / "results" / "whole_model.json"
"""What ``python -m benchmarks.whole_model`` identified on the embedded campaign."""


@cache
def device() -> Device:
    """Return the built-in device."""
    return load_device("freedom6s")


@cache
def equations() -> Equations:
    """Return the equations of the whole device."""
    return full_equations(device())


def values() -> dict[str, float]:
    """Return the identified value of every parameter of the whole device by id, SI units."""
    stored = json.loads(STORED.read_text(encoding="utf-8"))["machines"][0]["campaigns"]["planned"]["values"]
    return {q.id: float(stored.get(q.id, q.initial)) for q in equations().parameters}


def result() -> dict[str, Any]:
    """Return these values in the form of an identification.json without tests."""
    return {
        "schema": "identification/1", "device": "freedom6s", "campaign": "the embedded campaign", "measured": False,
        "configurations": [], "links": {}, "whole": values(),
    }  # fmt: skip


def without_bristle(all_values: Mapping[str, float], least: float) -> dict[str, float]:
    """Return values whose friction is viscous alone: a bristle of that stiffness and damping pulls at nothing."""
    soft = {id: least for id in all_values if id.startswith(("sigma0_", "sigma1_"))}
    return {**all_values, **soft}


@cache
def runs() -> tuple[Run, ...]:
    """Return the runs of the embedded campaign with all joints free."""
    campaign = Campaign.read(embedded_campaign("planned")).values
    return tuple(run for run in campaign.runs if len(run.free_joints) == len(device().joints))
