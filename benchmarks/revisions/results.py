"""A result without what tells of its run, and the figures of it that are compared: JSON in, JSON out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

ABOUT_THE_RUN = {"code", "command", "data", "date", "inputs", "software", "version", "wall_s"}
"""Keys of JSON that tell of the run, not of its result; three of them hold the digest of the code."""
UNKNOWN = {"fixed", "unidentifiable"}
"""Statuses of parameters that a fit does not determine."""


def result_alone(value: Any) -> Any:
    """Return JSON without the keys that tell of the run."""
    if isinstance(value, dict):
        return {key: result_alone(v) for key, v in value.items() if key not in ABOUT_THE_RUN}
    return [result_alone(v) for v in value] if isinstance(value, list) else value


def figures_of(result: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures of a result of ``identification.run`` or ``discrepancy.run``.

    Parameters
    ----------
    result
        Content of its JSON.

    Returns
    -------
    dict
        Of a fit: ``cost``; ``parameters``, by id value and standard error of those that the fit determines; and
        ``unseen``, by file the RMS of the residual [rad, m, N m or N] of runs that no fit saw. Of a search:
        ``verdict``; ``effects`` by id; their ``parameters``; and ``unseen``, the residual's RMS on unseen rows with
        these effects.
    """
    return _figures_of_search(result) if "verdict" in result else _figures_of_fit(result["configurations"][0])


def _figures_of_fit(configuration: Mapping[str, Any]) -> dict[str, Any]:
    rows = configuration["parameters"].items()
    known = {id: [row["value"], row["std"]] for id, row in rows if row["status"] not in UNKNOWN and row["std"]}
    unseen = {run["file"]: rms_of(run) for run in configuration["runs"] if run["use"] == "validate"}
    measured = {file: rms for file, rms in unseen.items() if rms is not None}
    return {"cost": configuration["cost"], "parameters": known, "unseen": measured}


def rms_of(run: Mapping[str, Any]) -> float | None:
    """Return the RMS of the residual of a run, a torque's where the torque was scored."""
    torque, position = run.get("rmse_Nm"), run.get("rmse_rad")
    return position if torque is None else torque


def _figures_of_search(result: Mapping[str, Any]) -> dict[str, Any]:
    parameters, names = {}, []
    for effect in result["effects"]:
        names.append(effect["id"])
        for id, row in effect["parameters"].items():
            parameters[id] = [row["value"], row["std"]]
    unseen = result["gap"].get("validate")
    return {
        "verdict": result["verdict"],
        "effects": names,
        "parameters": parameters,
        "unseen": {} if unseen is None else {"unseen rows": unseen["after"]},
    }
