"""The equations of one configuration: `Campaign` and `Device` in, `Equations` out, with the campaign's entries.

First guesses come from the device, or from the data of a single joint; friction that a device does not state
comes from the data, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from haptid.identification.first_guesses.driven_guess import guess_drive, with_torques
from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.first_guesses.plain_guess import guess_of_device
from haptid.identification.result.outcome import NoStartError
from haptid.measurement.checks.stated import Overrides, overridden, places
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.model.equations.parameter_ids import id_suffixes
from haptid.model.friction.registry import DEFAULT
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import NumericalError


def equations_for(
    campaign: Campaign,
    device: Device | None,
    free_joints: Sequence[int],
    posture: Sequence[float] | None = None,
) -> Equations:
    """Build the equations of one configuration with first guesses, bounds and priors.

    Parameters
    ----------
    campaign
        Campaign with runs and the entries ``[joint.J.parameters]``, which overrule all first guesses.
    device
        Device with first guesses; where None, the single joint's first guesses come from its runs.
    free_joints
        Numbers of the free joints.
    posture
        Positions of the locked joints [rad]; that of the first run where None.

    Returns
    -------
    Equations

    Raises
    ------
    InputError
        Where the campaign states a parameter that the equations lack, or impossible bounds, or where the device's first
        guesses give a single joint an impossible inertia.
    """
    joints = tuple(sorted(free_joints))
    runs = campaign.runs_of(joints)
    given = {j: campaign.parameter_overrides.get(j, {}) for j in joints}
    if device is None:
        return _single(joints[0], [run for run in runs if run.use == "fit"], given[joints[0]], campaign)
    if posture is None and runs:
        posture = tuple(float(x) for x in runs[0].posture)
    drive = campaign.drives.get(joints[0]) if len(joints) == 1 else None
    equations = configuration_equations(device, joints, posture, drive=drive)
    if drive is None:
        equations = guess_of_device(equations, runs, device, posture or (), stated_parameters(campaign, joints))
    if len(joints) == 1:
        return overridden(equations, given[joints[0]], joints[0], where=places(campaign, joints[0]))
    for j in joints:
        # Coupled equations have other inertial parameters than a joint alone: entries that they lack are skipped.
        known = {id: entry for id, entry in given[j].items() if _has(equations, f"{id}_{j}")}
        equations = overridden(equations, known, j, suffix=f"_{j}", where=places(campaign, j))
    return equations


def stated_parameters(campaign: Campaign, joints: Sequence[int]) -> tuple[str, ...]:
    """Return which parameters of a configuration the user states.

    Parameters
    ----------
    campaign
        Campaign with the entries ``[joint.J.parameters]``.
    joints
        Numbers of the free joints.

    Returns
    -------
    tuple of str
        Ids as the equations of these joints have them: with the joint's number where several are free.
    """
    stated: list[str] = []
    for joint, suffix in zip(joints, id_suffixes(joints), strict=True):
        stated += [f"{id}{suffix}" for id in campaign.parameter_overrides.get(joint, {})]
    return tuple(stated)


def _has(equations: Equations, id: str) -> bool:
    return any(q.id == id for q in equations.parameters)


def _single(joint: int, runs: Sequence[Run], given: Overrides, campaign: Campaign) -> Equations:
    prismatic = bool(runs[0].prismatic[0]) if runs else False
    friction, drive = campaign.friction.get(joint, DEFAULT), campaign.drives.get(joint)
    nominal = joint_equations(joint, prismatic=prismatic, friction=friction, drive=drive)
    equations = overridden(nominal, given, joint, where=places(campaign, joint))
    if not runs:
        return equations
    equations = guess_drive(equations, runs, given)
    return guess(equations, with_torques(equations, runs), given=given)


@contextmanager
def name_campaign_in_errors(campaign: Campaign, joints: Sequence[int]) -> Iterator[None]:
    """Put the user's file and keys before the message of a `NoStartError` from inside.

    Parameters
    ----------
    campaign
        Campaign whose folder is named.
    joints
        Joints whose keys are named.

    Raises
    ------
    NumericalError
        With the longer message, where the code inside raised one.
    """
    try:
        yield
    except NoStartError as error:
        keys = ", ".join(f"[joint.{j}.parameters]" for j in joints)
        msg = f"{campaign.folder / 'campaign.toml'}, {keys}: {error}"
        raise NumericalError(msg) from None
