"""Work through the cases of the panel: a campaign in, its outcome out.

The commands' own functions do it, on one thread and without pages. This module reads thresholds as it loads: it is
loaded after a change is made.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from haptid.discrepancy.finding.finding import as_json, find
from haptid.discrepancy.finding.torque_json import torque_json
from haptid.discrepancy.finding.torque_stages import find_torque
from haptid.discrepancy.study.study import study_of
from haptid.discrepancy.torque.choice import read_carried_fit, residual_of
from haptid.discrepancy.torque.study import torque_study_of
from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.sequence.result_json import step_json
from haptid.identification.sequence.sequence import Sequence
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.workers.workers import Here
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from haptid.uq.density.forward import kernel_of
from haptid.uq.result.infer import InferOptions, infer
from haptid.uq.result.record import as_json as posterior_json
from haptid.uq.sampling.sampling import SamplingOptions

SEED, STARTS = 0, 4
"""Seed and number of starts of all fits and searches."""
NUMBER = re.compile(r"\d[\d.e+-]*")
"""Of a sentence: it differs from run to run, while the words are the outcome."""
SHORT = SamplingOptions(ensembles=2, chunk=10, burn=10, pilot=0, longest=20, seed=SEED)


def search_joint(campaign: Path, out: Path, *, entries: list[str]) -> dict[str, Any]:
    """Search for what is missing in the campaign's joint, in its position or torque as the command chooses.

    Parameters
    ----------
    campaign, out
        Folders of the campaign and of the FMUs.
    entries
        Ids of the effects of the catalogue that are searched.

    Returns
    -------
    dict
        Outcome, see `studies.thresholds.outcome`.
    """
    read = campaign_for_command(str(campaign))
    (joint,) = read.joints
    if residual_of(read, joint, out) == "torque":  # there is no identification, whose plain model asks for both
        return _search_torque(read, joint, out, entries)
    study = study_of(read, joint, _chosen(entries), threads=1)
    finding = find(study, out, kind="python", seed=SEED, starts=STARTS, tell=ignore_progress)
    return outcome_of_search(as_json(finding, measured=False, seed=SEED))


def _search_torque(read: Campaign, joint: int, out: Path, entries: list[str]) -> dict[str, Any]:
    base = equations_for(read, device_of(read), (joint,))
    study = torque_study_of(read, joint, read_carried_fit(read, (joint,), base, out, springless=True), threads=1)
    finding = find_torque(study, _chosen(entries), out, kind="python", seed=SEED, starts=STARTS, tell=ignore_progress)
    return outcome_of_search(torque_json(finding, measured=False, seed=SEED))


def _chosen(entries: list[str]) -> dict[str, Effect]:
    return {key: effect for key, effect in catalogue().items() if effect.id in entries}


def outcome_of_search(found: dict[str, Any]) -> dict[str, Any]:
    """Take the outcome of a search from the content of its JSON.

    Parameters
    ----------
    found
        Content of ``discrepancy/joint<j>.json``.

    Returns
    -------
    dict
        Outcome, see `studies.thresholds.outcome`.
    """
    gap = found["gap"]["validate"]
    return {
        "verdict": found["verdict"],
        "names": sorted(effect["id"] for effect in found["effects"]),
        "closed": gap["closed"],
        "times_noise": gap["after"] / gap["noise"] if gap["noise"] else None,
        "simulations": found["simulations"],
        "values": {
            f"{effect['id']}.{id}": [p["value"], p["std"]]
            for effect in found["effects"]
            for id, p in effect["parameters"].items()
            if p["std"]
        },
    }


def identify(campaign: Path, out: Path) -> dict[str, Any]:  # noqa: ARG001 (a fit in process writes nothing)
    """Fit the campaign's joint as `identification.run` does, in process, with profiles.

    Parameters
    ----------
    campaign
        Folder of the campaign.
    out
        Folder for results; a fit in process writes nothing.

    Returns
    -------
    dict
        Outcome, see `studies.thresholds.outcome`.
    """
    read = campaign_for_command(str(campaign))
    device = device_of(read)
    options = FitOptions(starts=STARTS, seed=SEED, profile=True)
    sequence = Sequence(
        campaign=read, device=device, build=KernelSimulator.of, options=options, workers=Here(), kept={}
    )
    (step,) = sequence.steps(configurations_of(read, device, None))
    told = step_json(step)
    parameters = told["parameters"]
    over = [run["rmse_over_noise"] for run in told["runs"] if run["use"] == "validate"]
    return {
        "verdict": f"{told['outcome']} in {told['residual']}",
        "names": [f"{id} {p['status']}" for id, p in parameters.items() if p["status"] != "fixed"],
        "closed": None,
        "times_noise": max((x for x in over if x is not None), default=None),
        "simulations": told["simulations"],
        "values": {
            id: [p["value"], p["std"]] for id, p in parameters.items() if p["status"] == "identified" and p["std"]
        },
    }


def infer_posterior(campaign: Path, out: Path) -> dict[str, Any]:  # noqa: ARG001 (no chains are kept)
    """Fit the campaign's joint and sample its posterior by short chains.

    Parameters
    ----------
    campaign
        Folder of the campaign.
    out
        Folder for results; no chains are kept.

    Returns
    -------
    dict
        Outcome, see `studies.thresholds.outcome`.
    """
    read = campaign_for_command(str(campaign))
    (one,) = configurations_of(read, device_of(read), None)
    equations = equations_for(read, device_of(read), one.free_joints, one.posture)
    found = fit(kernel_of(equations), one.runs, options=FitOptions(starts=STARTS, seed=SEED), workers=Here())
    posterior = infer(
        kernel_of(found.equations),
        one.runs,
        np.array(found.theta),
        InferOptions(sampling=SHORT, noise_given=read.noise_given, sensitivity=False),
        joint=one.free_joints[0],
    )
    told = posterior_json(posterior)
    return {
        "verdict": f"{told['noise_model']['id']}, {'sound' if told['sound'] else 'not sound'}",
        "names": [NUMBER.sub("…", p["verdict"]) for p in told["parameters"].values()],
        "closed": None,
        "times_noise": None,
        "simulations": None,
        "values": {id: [p["mean"], p["std"]] for id, p in told["parameters"].items()},
    }
