"""One set of real measurements through both commands: `MachineSet` in, entry of the stored JSON and picture out."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machines.commands import find_missing, identify
from benchmarks.machines.figures import Results
from benchmarks.machines.sets import MachineSet
from haptid.identification.baseline.driven import compare_driven
from haptid.identification.baseline.prediction import predict_unseen
from haptid.identification.sequence.configurations import configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.report.common.style import png
from haptid.report.identification.plain_pictures import plain_figure

VISCOUS_ID = "sigma2"
"""Id of the viscous friction in the law that all sets are fitted with; the plain model calls it Fv."""

DRIVE_IDS = ("torque_constant", "resistance_ohm")
"""Ids of a drive's parameters, which no plain model has."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluated:
    """Entry of a set and the bytes of its picture; no picture without a result."""

    entry: dict[str, Any]
    picture: bytes | None


def evaluate(machine: MachineSet, data: Path, out: Path, limit: float) -> Evaluated:
    """Write the campaign of a set, run both commands on it and collect what the page shows.

    Parameters
    ----------
    machine
        Set of measurements.
    data
        Folder with the folders of all sets.
    out
        Folder for campaign and results.
    limit
        Longest time of a command [s].

    Returns
    -------
    Evaluated
    """
    campaign = out / machine.folder
    shutil.rmtree(campaign, ignore_errors=True)
    campaign.mkdir(parents=True)
    machine.write(data / machine.folder, campaign)
    written = out / f"{machine.folder}_results"
    results = Results(
        identified=identify(campaign, written, limit),
        missing=find_missing(campaign, machine.joints, written, limit),
        campaign=campaign,
    )
    entry, found = results.configuration, results.missing.result
    picture = None if entry is None else _picture(campaign, entry)
    return Evaluated(
        entry={
            "folder": machine.folder,
            "title": machine.title,
            "source": machine.source,
            "commands": [call.as_json() for call in (results.identified, results.missing)],
            "figures": [figure.as_json() for figure in machine.figures(results)],
            "identification": None if entry is None else _identification_json(entry, machine.published),
            "missing": None if found is None else _missing_json(found),
            "picture": None if picture is None else f"real_machines_{machine.folder}.png",
        },
        picture=picture,
    )


def _identification_json(entry: Mapping[str, Any], published: Mapping[str, float]) -> dict[str, Any]:
    """Keep what the page shows of a configuration."""
    baseline = entry["baseline"]["parameters"] if entry["baseline"] else {}
    rows = []
    of_drive = [id for id in DRIVE_IDS if id in entry["parameters"]]
    for id in dict.fromkeys([*published, *baseline, *of_drive]):
        plain, own = baseline.get(id), entry["parameters"].get(id.replace("Fv", VISCOUS_ID))
        told = plain or own
        if told is None or (id not in published and told["std"] is None):
            continue
        rows.append({"id": id, "unit": told["unit"], "published": published.get(id), "plain": plain, "fit": own})
    return {
        "outcome": entry["outcome"],
        "residual": entry["residual"],
        "why": entry["why"],
        "parameters": rows,
        "delay": entry["baseline"]["delay"] if entry["baseline"] else None,
        "runs": [
            {key: run[key] for key in ("file", "use", "rmse_over_noise", "figures")}
            for run in entry["runs"]
            if run["figures"]
        ],
    }


def _missing_json(found: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "verdict": found["verdict"],
        "sentence": found["sentence"],
        "effects": found["effects"],
        "gap": found["gap"],
        "residual": found.get("residual", "position"),
    }


def _picture(campaign: Path, entry: Mapping[str, Any]) -> bytes | None:
    """Draw the longest unseen run as fit and plain model predict it."""
    read = campaign_for_command(campaign)
    device = device_of(read)
    configuration = configurations_of(read, device)[-1]
    equations = equations_for(read, device, configuration.free_joints, configuration.posture)
    theta = np.array([entry["parameters"][q.id]["value"] for q in equations.parameters])
    compared = compare_driven(equations, theta, configuration.runs, device, configuration.posture)
    prediction = predict_unseen(compared)
    if prediction is None:
        return None
    return png(plain_figure(prediction))
