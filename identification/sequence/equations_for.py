"""The equations of one configuration of a campaign: from the device or from the data, with what the campaign states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from haptid.identification.fit.initial_guess import guess
from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.friction.registry import DEFAULT
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError

Overrides = Mapping[str, Mapping[str, Any]]


def device_of(campaign: Campaign) -> Device | None:
    """Return the campaign's device with the friction laws that the campaign names, or None for ``single_joint``."""
    if campaign.device == SINGLE_JOINT:
        return None
    return load_device(campaign.device, campaign.folder).with_friction(campaign.friction)


def equations_for(
    campaign: Campaign,
    device: Device | None,
    free_joints: Sequence[int],
    posture: Sequence[float] | None = None,
) -> Equations:
    """Return the equations of ``free_joints``, the others locked at ``posture`` (that of the first run where None).

    First guesses are the device's, or come from the data for ``single_joint``; ``[joint.J.parameters]`` overrules them.
    """
    joints = tuple(sorted(free_joints))
    runs = campaign.runs_of(joints)
    given = {j: campaign.parameter_overrides.get(j, {}) for j in joints}
    if device is None:
        friction = campaign.friction.get(joints[0], DEFAULT)
        return _single(joints[0], [run for run in runs if run.use == "fit"], given[joints[0]], friction)
    if posture is None and runs:
        posture = tuple(float(x) for x in runs[0].posture)
    equations = configuration_equations(device, joints, posture)
    if len(joints) == 1:
        return overridden(equations, given[joints[0]], joints[0])
    for j in joints:
        known = {id: entry for id, entry in given[j].items() if _has(equations, f"{id}_{j}")}
        equations = overridden(equations, known, j, suffix=f"_{j}")
    return equations


def _has(equations: Equations, id: str) -> bool:
    return any(q.id == id for q in equations.parameters)


def _single(joint: int, runs: Sequence[Run], given: Overrides, friction: str) -> Equations:
    prismatic = bool(runs[0].prismatic[0]) if runs else False
    equations = overridden(joint_equations(joint, prismatic=prismatic, friction=friction), given, joint)
    return guess(equations, runs, given=given) if runs else equations


def overridden(equations: Equations, given: Overrides, joint: int, suffix: str = "") -> Equations:
    """Return the equations with what a campaign states of the parameters of one joint."""
    quantities = {q.id: q for q in equations.parameters}
    changes = {}
    for id, entry in given.items():
        if f"{id}{suffix}" not in quantities:
            where = f"[joint.{joint}.parameters] {id}"
            known = ", ".join(q.removesuffix(suffix) for q in quantities)
            raise InputError(where, expected=f"a parameter of this joint ({known})", got=id)
        changes[f"{id}{suffix}"] = changed(quantities[f"{id}{suffix}"], entry, f"[joint.{joint}.parameters] {id}")
    return equations.with_parameters(changes)


def changed(quantity: Quantity, entry: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return the fields that an entry ``{initial, lower, upper, prior, fixed}`` changes."""
    if "fixed" in entry:
        value = float(entry["fixed"])
        return {
            "initial": value,
            "fixed": True,
            "prior": None,
            "lower": min(quantity.lower, value),
            "upper": max(quantity.upper, value),
        }
    prior = Normal(**{k: float(v) for k, v in entry["prior"].items()}) if "prior" in entry else quantity.prior
    initial = float(entry.get("initial", prior.mean if "prior" in entry and prior else quantity.initial))
    lower = float(entry.get("lower", min(quantity.lower, initial)))
    upper = float(entry.get("upper", max(quantity.upper, initial)))
    if quantity.scale == "log" and not lower > 0:
        raise InputError(where, expected="a lower bound and an initial value above 0", got=f"{lower}, {initial}")
    initial = min(max(initial, lower), upper)
    fixed = quantity.fixed and "prior" not in entry
    return {"initial": initial, "lower": lower, "upper": upper, "prior": prior, "fixed": fixed}
