"""Put the parameters that a campaign states into equations: `Equations` and overrides in, `Equations` out.

Checks and fits use the same functions, so that a campaign that passes the checks does not fail in the fit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from haptid.measurement.format.devices import device_of
from haptid.measurement.format.toml_source import TomlSource
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal, Quantity
from haptid.model.friction.registry import DEFAULT
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

Overrides = Mapping[str, Mapping[str, Any]]


def check_stated(campaign: Campaign) -> Campaign:
    """Refuse a campaign where the equations of its joints cannot take a stated parameter.

    For example, a joint of a device has no ``gravity_cos`` and ``gravity_sin`` where its axis is vertical.

    Parameters
    ----------
    campaign
        As it was read. Joints that no run frees alone are not checked.

    Returns
    -------
    Campaign
        The same, unchanged.

    Raises
    ------
    InputError
        Where a parameter does not exist, its value or bounds are impossible, or the file of the device is at fault.
    """
    device = device_of(campaign)
    for joint, stated in campaign.parameter_overrides.items():
        _check_joint(campaign, device, joint, stated)
    return campaign


def _check_joint(campaign: Campaign, device: Device | None, joint: int, stated: Overrides) -> None:
    runs = campaign.runs_of((joint,))
    if not runs:  # no run frees the joint alone: its parameters depend on which joints are free with it
        return
    if device is None:
        friction = campaign.friction.get(joint, DEFAULT)
        slides, drive = bool(runs[0].prismatic[0]), campaign.drives.get(joint)
        equations = joint_equations(joint, prismatic=slides, friction=friction, drive=drive)
    else:
        posture = tuple(float(x) for x in runs[0].posture)
        equations = configuration_equations(device, (joint,), posture, drive=campaign.drives.get(joint))
    overridden(equations, stated, joint, where=places(campaign, joint))


def places(campaign: Campaign, joint: int) -> Callable[[str], str]:
    """Return a function that names the place of a joint's parameter in ``campaign.toml``.

    Parameters
    ----------
    campaign
        Its folder holds the file; without a file, as for a campaign made in memory, no line is named.
    joint
        Number of the joint.

    Returns
    -------
    callable
        From the parameter's id to file, line and key.

    Raises
    ------
    InputError
        Where campaign.toml cannot be read, or is no TOML.
    """
    path, section = Path(campaign.folder) / "campaign.toml", f"joint.{joint}.parameters"
    source = TomlSource.parse(path) if path.is_file() else None
    return lambda id: f"{path}, {section}.{id}" if source is None else source.where(section, id)


def overridden(
    equations: Equations, given: Overrides, joint: int, suffix: str = "", where: Callable[[str], str] | None = None
) -> Equations:
    """Return the equations with the parameters that a campaign states of one joint.

    Parameters
    ----------
    equations
        Equations of the configuration.
    given
        ``{id: {initial, lower, upper, prior, fixed}}``, in SI units.
    joint
        Number of the joint, for errors.
    suffix
        End of the ids of this joint's parameters where several joints are free, as ``_4``; else "".
    where
        Names the place of a parameter in the user's file; None for campaigns without a file.

    Returns
    -------
    Equations
        With other initial values, bounds and priors; formulas stay.

    Raises
    ------
    InputError
        Where the equations have no such parameter, or its bounds are impossible.
    """
    quantities = {q.id: q for q in equations.parameters}
    changes = {}
    for id, entry in given.items():
        place = f"[joint.{joint}.parameters] {id}" if where is None else where(id)
        if f"{id}{suffix}" not in quantities:
            todo = did_you_mean(id, [q.removesuffix(suffix) for q in quantities])
            raise InputError(place, expected="a parameter of this joint", got=id, todo=todo)
        changes[f"{id}{suffix}"] = fields_changed_by(quantities[f"{id}{suffix}"], entry, place)
    return equations.with_parameters(changes)


def fields_changed_by(quantity: Quantity, entry: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return the fields of a quantity that a stated entry changes.

    Parameters
    ----------
    quantity
        The parameter as the device or the friction law has it.
    entry
        ``{initial, lower, upper, prior, fixed}``, each optional, in SI units.
    where
        Place of the entry, for errors.

    Returns
    -------
    dict
        ``initial``, ``lower``, ``upper``, ``prior`` and ``fixed`` of the changed quantity.

    Raises
    ------
    InputError
        Where lower < upper does not hold, or a quantity on a logarithmic scale has a bound that is not positive.

    Notes
    -----
    A fixed value loses its prior. An initial value defaults to the mean of a stated prior, and bounds that are not
    stated widen to hold it; stated bounds clip it. A stated prior frees a quantity that the device fixes.
    """
    if "fixed" in entry:
        value = float(entry["fixed"])
        return {
            "initial": value,
            "fixed": True,
            "prior": None,
            "lower": min(quantity.lower, value),
            "upper": max(quantity.upper, value),
        }
    told = entry.get("prior")
    prior = quantity.prior if told is None else Normal(mean=float(told["mean"]), std=float(told["std"]))
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
