"""``identification.json`` of a calibrated FMU (schema identification/1): `Calibration` in, JSON data out."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np

from haptid.identification.calibration.calibrate import Calibration
from haptid.identification.calibration.words import sentence_of
from haptid.identification.result.fit import RunScore
from haptid.identification.sequence.result_json import SCHEMA, finite, parameter_json
from haptid.measurement.values.run import Array, Run

CAMPAIGN, MODEL = "campaign_folder", "model_file"
"""Keys that hold the campaign and the FMU as paths from the folder of the results."""


def calibration_json(calibration: Calibration, head: dict[str, Any], out: Path) -> dict[str, Any]:
    """Convert a calibration to the content of ``identification.json``.

    Parameters
    ----------
    calibration
        Result of the fit.
    head
        Seed, software and command.
    out
        Folder of the results, from which the paths of campaign and FMU are written.

    Returns
    -------
    dict
        JSON data, with one configuration that has no ``free_joints``.
    """
    campaign = calibration.campaign
    return {
        "schema": SCHEMA,
        "model": campaign.model.name,
        MODEL: _path_from(out, campaign.model),
        "model_sha256": hashlib.sha256(campaign.model.read_bytes()).hexdigest(),
        "campaign": campaign.title,
        CAMPAIGN: _path_from(out, campaign.folder),
        "measured": campaign.measured,
        **head,
        "complete": True,
        "configurations": [_configuration(calibration)],
        "links": {},
        "verification": {"runs": []},
    }


def _path_from(out: Path, path: Path) -> str:
    """Return a path relative to the results, so that both may move together; absolute across drives."""
    try:
        return Path(os.path.relpath(path.resolve(), out.resolve())).as_posix()
    except ValueError:
        return path.resolve().as_posix()


def _configuration(calibration: Calibration) -> dict[str, Any]:
    fit, campaign = calibration.fit, calibration.campaign
    names = [q.structured for q in fit.equations.parameters]
    return {
        "parameters": {
            q.structured: parameter_json(q, value, std, fit.statuses[q.id], fit.outcome)
            for q, value, std in zip(fit.equations.parameters, fit.theta, fit.std, strict=True)
        },
        "outputs": {
            name: {"unit": unit, "noise": float(sigma), "noise_given": campaign.noise_given[name]}
            for name, unit, sigma in zip(campaign.outputs, calibration.units, campaign.runs[0].sensor_std, strict=True)
        },
        "runs": [run_json(score, _run(calibration, score.file), campaign.outputs) for score in fit.runs],
        "cost": float(fit.cost),
        "outcome": fit.outcome.label,
        "outcome_sentence": sentence_of(fit.outcome),
        "starts": fit.starts,
        "simulations": fit.simulations,
        "simulation_s": round(calibration.simulation_s, 6),
        "wall_s": round(fit.wall_s, 3),
        "basins": [
            {
                "rmse_over_noise": float(basin.over_noise),
                "starts": list(basin.starts),
                "parameters": dict(zip(names, basin.theta.tolist(), strict=True)),
            }
            for basin in fit.basins
        ],
        "combinations": [
            {
                "coefficients": {fit.equations.parameter(id).structured: c for id, c in one.coefficients.items()},
                "value": one.value,
                "std": one.std,
            }
            for one in fit.combinations
        ],
        "residual_correlation_rows": float(fit.correlation_time),
        "free": [fit.equations.parameter(id).structured for id in fit.free],
        "covariance": fit.covariance.tolist(),
    }


def _run(calibration: Calibration, file: str) -> Run:
    return next(run for run in calibration.campaign.runs if run.file == file)


def run_json(score: RunScore, run: Run, outputs: tuple[str, ...]) -> dict[str, Any]:
    """Convert the score of a run to JSON data, its figures by output.

    Parameters
    ----------
    score
        Score with an RMS by output.
    run
        The run, with the noise of every output.
    outputs
        Names of the outputs.

    Returns
    -------
    dict
        ``rmse`` in each output's unit.
    """
    return {
        "file": score.file,
        "use": score.use,
        "rmse": _by_output(outputs, score.rmse),
        "rmse_over_noise": _by_output(outputs, score.rmse / run.sensor_std),
        "nrmse": finite(score.nrmse),
    }


def _by_output(outputs: tuple[str, ...], values: Array) -> dict[str, float | None]:
    return {name: finite(float(value)) for name, value in zip(outputs, np.asarray(values), strict=True)}
