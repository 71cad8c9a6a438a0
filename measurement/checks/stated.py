"""What the device says of a campaign: whether its joints have the parameters that are stated, and torque limits."""

from __future__ import annotations

from haptid.measurement.format.devices import SINGLE_JOINT
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.friction.registry import DEFAULT
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean


def check_stated(campaign: Campaign) -> Campaign:
    """Return the campaign, refused where it states a parameter that the joint does not have.

    The joint of a device has no ``gravity_cos`` and ``gravity_sin`` where its axis is vertical, for example.

    Raises
    ------
    InputError
        With the parameters that the joint has.
    """
    if campaign.parameter_overrides:
        device = _device(campaign)
        for joint, stated in campaign.parameter_overrides.items():
            _check_joint(campaign, device, joint, tuple(stated))
    return campaign


def torque_limits(campaign: Campaign) -> dict[int, float]:
    """Return the largest torque (force) of the device's joints [N m] ([N]), infinite where it states none."""
    device = _device(campaign)
    return {} if device is None else {j: joint.torque_limit for j, joint in enumerate(device.joints)}


def _device(campaign: Campaign) -> Device | None:
    """Return the campaign's device with the friction laws that the campaign names."""
    if campaign.device == SINGLE_JOINT:
        return None
    return load_device(campaign.device, campaign.folder).with_friction(campaign.friction)


def _check_joint(campaign: Campaign, device: Device | None, joint: int, stated: tuple[str, ...]) -> None:
    runs = campaign.runs_of((joint,))
    if not runs:  # never alone: what its equations hold depends on the others
        return
    if device is None:
        friction = campaign.friction.get(joint, DEFAULT)
        equations = joint_equations(joint, prismatic=bool(runs[0].prismatic[0]), friction=friction)
    else:
        equations = configuration_equations(device, (joint,), tuple(float(x) for x in runs[0].posture))
    known = tuple(q.id for q in equations.parameters)
    for name in stated:
        if name not in known:
            where = f"{campaign.folder / 'campaign.toml'}, joint.{joint}.parameters.{name}"
            raise InputError(where, expected="a parameter of this joint", got=name, todo=did_you_mean(name, known))
