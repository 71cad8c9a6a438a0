"""Content of ``identification.json`` in, data frames out: estimates, links, outcomes and residuals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from haptid.identification.output.plain_comparison import ConstantTorque
from haptid.identification.result.outcome import tell_status
from haptid.identification.sequence.configurations import Configuration
from haptid.measurement.values.units import unit_for
from haptid.model.equations.joint_parameters import sliding

PARAMETER = ("value", "std", "unit", "status", "description")
"""Keys of a parameter in ``identification.json`` that a table shows."""


def named_entries(data: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield name and entry of each configuration; several postures of the same joints are numbered.

    Parameters
    ----------
    data
        Content of ``identification.json``.

    Yields
    ------
    name, entry
        As ``joint 3``, and the element of ``configurations``.
    """
    seen: dict[tuple[int, ...], int] = {}
    for entry in data["configurations"]:
        free = tuple(entry["free_joints"])
        seen[free] = seen.get(free, 0) + 1
        yield Configuration(free_joints=free, posture=(), runs=(), number=seen[free]).name, entry


def table_estimates(data: Mapping[str, Any]) -> pd.DataFrame:
    """Return the estimates, as `Identified.summary` describes them.

    Parameters
    ----------
    data
        Content of ``identification.json``.

    Returns
    -------
    DataFrame
        One row a configuration and parameter.
    """
    rows = []
    for name, entry in named_entries(data):
        for id, one in entry["parameters"].items():
            row = {"configuration": name, "parameter": id, **{key: one.get(key) for key in PARAMETER}}
            if row["status"] == "unidentifiable":
                row["std"] = math.nan
            row["status"] = tell_status(row["status"], entry.get("outcome", ""))
            rows.append(row)
        rows += [{"configuration": name, **row} for row in _constant_torques(entry)]
    return pd.DataFrame(rows).set_index(["configuration", "parameter"])


def _constant_torques(entry: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of the constant torques of an entry whose result is the plain model."""
    if entry.get("outcome") != "plain" or not entry.get("baseline"):
        return []
    rows = []
    for id, one in entry["baseline"]["parameters"].items():
        if id.split("_")[0] != "offset":
            continue
        slides = one["unit"] == "N"
        torque = ConstantTorque(
            id=id,
            value=one["value"],
            std=math.nan if one["std"] is None else one["std"],
            unit=one["unit"],
            carried_by=("gravity_cos",) if slides else ("Ks", "epos"),
        )
        about = "force, which gravity_cos holds" if slides else "torque, which Ks and epos stand for"
        row = {"parameter": id, "value": torque.value, "std": torque.std, "unit": torque.unit, "status": torque.status}
        rows.append({**row, "description": f"constant {about}"})
    return rows


def table_links(data: Mapping[str, Any]) -> pd.DataFrame:
    """Return the physical parameters of the links, as `Identified.links` describes them.

    Parameters
    ----------
    data
        Content of ``identification.json``.

    Returns
    -------
    DataFrame
        One row a link and parameter; empty where the device was not identified as a whole.
    """
    rows = [
        {"link": link, "parameter": id, **one} for link, table in data["links"].items() for id, one in table.items()
    ]
    columns = ["link", "parameter", "value", "std", "unit", "status"]
    return pd.DataFrame(rows, columns=columns).set_index(["link", "parameter"])


def table_outcomes(data: Mapping[str, Any]) -> pd.DataFrame:
    """Return how the fits ended, as `Identified.outcomes` describes it.

    Parameters
    ----------
    data
        Content of ``identification.json``.

    Returns
    -------
    DataFrame
        One row a configuration.
    """
    runs = table_runs(data)
    rows = []
    for name, entry in named_entries(data):
        own = runs[runs.configuration == name]
        worst = {f"{use}_over_noise": own.rms_over_noise[own.use == use].max() for use in ("fit", "validate")}
        said = {"outcome": entry["outcome"], "sentence": entry.get("outcome_sentence", "")}
        rows.append({"configuration": name, **said, **worst})
    return pd.DataFrame(rows).set_index("configuration")


def table_runs(data: Mapping[str, Any]) -> pd.DataFrame:
    """Return the residuals of all runs, as `Identified.runs` describes them.

    Parameters
    ----------
    data
        Content of ``identification.json``.

    Returns
    -------
    DataFrame
        One row a configuration and run.
    """
    rows = []
    for name, entry in named_entries(data):
        torque = entry.get("scored") == "torque"
        for run in entry["runs"]:
            rms = run["rmse_Nm"] if torque else run["rmse_rad"]
            rows.append({
                "configuration": name, "file": run["file"], "use": run["use"], "rms": rms,
                "unit": unit_for("N m" if torque else "rad", _prismatic(entry)),
                "rms_over_noise": run["rmse_over_noise"],
            })  # fmt: skip
    return pd.DataFrame(rows)


def _prismatic(entry: Mapping[str, Any]) -> list[bool]:
    """Return whether each free joint of a configuration is prismatic, by the units of their springs."""
    springs = [one for id, one in entry["parameters"].items() if id == "Ks" or id.startswith("Ks_")]
    return [one["unit"] == sliding("N m/rad") for one in springs] or [False]
