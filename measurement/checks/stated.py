"""What a campaign states of parameters, put into the equations of its device: one way for checks and for fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.friction.registry import DEFAULT
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

Overrides = Mapping[str, Mapping[str, Any]]


def check_stated(campaign: Campaign) -> Campaign:
    """Return the campaign, refused where it states what the equations of its joints cannot take.

    The joint of a device has no ``gravity_cos`` and ``gravity_sin`` where its axis is vertical, for example.

    Raises
    ------
    InputError
        With the parameters that the joint has, with what contradicts the device, or with what is wrong with its file.
    """
    device = _device(campaign)
    for joint, stated in campaign.parameter_overrides.items():
        _check_joint(campaign, device, joint, stated)
    return campaign


def _device(campaign: Campaign) -> Device | None:
    """Return the campaign's device with the friction laws that the campaign names."""
    if campaign.device == SINGLE_JOINT:
        return None
    return load_device(campaign.device, campaign.folder).with_friction(campaign.friction)


def _check_joint(campaign: Campaign, device: Device | None, joint: int, stated: Overrides) -> None:
    runs = campaign.runs_of((joint,))
    if not runs:  # never alone: what its equations hold depends on the others
        return
    if device is None:
        friction = campaign.friction.get(joint, DEFAULT)
        equations = joint_equations(joint, prismatic=bool(runs[0].prismatic[0]), friction=friction)
    else:
        equations = configuration_equations(device, (joint,), tuple(float(x) for x in runs[0].posture))
    overridden(equations, stated, joint, where=places(campaign, joint))


def places(campaign: Campaign, joint: int) -> Callable[[str], str]:
    """Return what names the place of a joint's parameter in ``campaign.toml``, with its line where it can be told."""
    path, section = Path(campaign.folder) / "campaign.toml", f"joint.{joint}.parameters"
    source = TomlSource.read(path) if path.is_file() else None
    return lambda id: f"{path}, {section}.{id}" if source is None else source.where(section, id)


def overridden(
    equations: Equations, given: Overrides, joint: int, suffix: str = "", where: Callable[[str], str] | None = None
) -> Equations:
    """Return the equations with what a campaign states of the parameters of one joint.

    Parameters
    ----------
    given
        ``{id: {initial, lower, upper, prior, fixed}}``.
    suffix
        What the ids of this joint's parameters end in, where several joints are free.
    where
        Names the place of a parameter in the user's file.
    """
    quantities = {q.id: q for q in equations.parameters}
    changes = {}
    for id, entry in given.items():
        place = f"[joint.{joint}.parameters] {id}" if where is None else where(id)
        if f"{id}{suffix}" not in quantities:
            todo = did_you_mean(id, [q.removesuffix(suffix) for q in quantities])
            raise InputError(place, expected="a parameter of this joint", got=id, todo=todo)
        changes[f"{id}{suffix}"] = changed(quantities[f"{id}{suffix}"], entry, place)
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
    if not lower < upper:
        todo = "state both bounds" if "lower" not in entry or "upper" not in entry else ""
        raise InputError(where, expected="lower < upper", got=f"lower {lower:g}, upper {upper:g}", todo=todo)
    if quantity.scale == "log" and not lower > 0:
        raise InputError(where, expected="a lower bound and an initial value above 0", got=f"{lower}, {initial}")
    initial = min(max(initial, lower), upper)
    fixed = quantity.fixed and "prior" not in entry
    return {"initial": initial, "lower": lower, "upper": upper, "prior": prior, "fixed": fixed}
