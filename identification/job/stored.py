"""Fits of an earlier identification again: content of ``identification.json`` and `Campaign` in, `Step`s out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration, configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.sequence.result_json import fit_from_json
from haptid.identification.sequence.resume import data_digest
from haptid.identification.sequence.step import Step
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.errors import InputError


def stored_steps(
    data: Mapping[str, Any], campaign: Campaign, device: Device | None, where: str
) -> tuple[Step, ...]:  # fmt: skip
    """Rebuild the fitted configurations that stored results hold, without fitting.

    Parameters
    ----------
    data
        Content of ``identification.json``.
    campaign
        Campaign that the results are from, ready for fits.
    device
        Device of the campaign; None for a single joint.
    where
        File of the results, for errors.

    Returns
    -------
    tuple of Step
        In the order of the results, without comparisons with the plain model.

    Raises
    ------
    InputError
        Where a configuration was fitted to other runs or entries, or by another version of haptid.
    """
    known = {data_digest(campaign, device, one): one for one in configurations_of(campaign, device)}
    steps = []
    for number, entry in enumerate(data["configurations"]):
        if entry.get("data") not in known:
            got = "fits of other runs or entries, or of another version of haptid"
            place = f"{where}: configurations[{number}]"
            raise InputError(place, expected="a fit of this campaign", got=got, todo="identify the campaign again")
        steps.append(_step(entry, campaign, device, known[entry["data"]]))
    return tuple(steps)


def _step(entry: Mapping[str, Any], campaign: Campaign, device: Device | None, tested: Configuration) -> Step:
    equations = equations_for(campaign, device, tested.free_joints, tested.posture)
    fitted = fit_from_json(entry, equations)
    return Step(configuration=tested, fit=fitted, torque_scored=fitted.outcome is Outcome.TORQUE_SCORED)
