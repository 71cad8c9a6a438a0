"""``fleet.json`` and ``fleet.csv``: identified devices and `Comparison`s in, their content out."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from haptid.fleet.comparison import FEWEST_DEVICES, Comparison

SCHEMA = "fleet/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class Identified:
    """How the identification of one device ended.

    Parameters
    ----------
    name, campaign, folder
        Name of the device, its campaign, and the folder of its results.
    error
        Last line that a failed command said; empty where the device is identified.
    kept
        Whether the results of an earlier call were taken.
    wall_s
        Duration [s].
    """

    name: str
    campaign: Path
    folder: Path
    error: str
    kept: bool
    wall_s: float


def device_json(one: Identified, result: Mapping[str, Any] | None) -> dict[str, Any]:
    """Convert how a device ended to an entry of ``devices``.

    Parameters
    ----------
    one
        How its identification ended.
    result
        Content of its identification.json; None where it failed.

    Returns
    -------
    dict
        ``worst_over_noise`` is the largest RMS error over the noise of a held-out run [1]; it and ``measured`` are None
        where the identification failed.
    """
    worst = None
    if result is not None:
        runs = [run for entry in result["configurations"] for run in entry["runs"] if run["use"] == "validate"]
        worst = max((score for run in runs for score in _scores(run["rmse_over_noise"])), default=None)
    return {
        "name": one.name,
        "campaign": str(one.campaign),
        "results": str(one.folder),
        "outcome": "failed" if one.error else "identified",
        "error": one.error,
        "kept": one.kept,
        "wall_s": round(one.wall_s, 3),
        "measured": None if result is None else result["measured"],
        "worst_over_noise": worst,
    }


def _scores(over_noise: float | Mapping[str, float | None] | None) -> list[float]:
    """Return the scores of a run: one of joints, one by output of an FMU, none where it is not finite."""
    scores = over_noise.values() if isinstance(over_noise, Mapping) else [over_noise]
    return [score for score in scores if score is not None]


def fleet_json(devices: Sequence[Mapping[str, Any]], comparisons: Sequence[Comparison]) -> dict[str, Any]:
    """Put devices and comparisons together to the content of fleet.json.

    Parameters
    ----------
    devices
        Entries as `device_json` makes them.
    comparisons
        Every parameter over the devices.

    Returns
    -------
    dict
        Devices, comparisons, ``deviating`` (device, configuration, parameter and z of each that deviates), and the
        sentence that sums them up.
    """
    deviating = [
        {"device": m.device, "configuration": one.configuration, "parameter": one.parameter, "z": m.z}
        for one in comparisons
        for m in one.members
        if m.deviates
    ]
    judged = sum(one.limit is not None for one in comparisons)
    return {
        "schema": SCHEMA,
        "devices": list(devices),
        "sentence": _sentence(deviating, judged, sum(not device["error"] for device in devices)),
        "deviating": deviating,
        "parameters": [asdict(one) for one in comparisons],
    }


def _sentence(deviating: Sequence[Mapping[str, Any]], judged: int, identified: int) -> str:
    if not judged:
        return (
            f"{identified} devices were identified: nobody is judged, since that takes {FEWEST_DEVICES} in which "
            "a parameter is identified."
        )
    if not deviating:
        return f"No device deviates from the others in any of {judged} parameters."
    by_device: dict[str, list[str]] = {}
    for one in deviating:
        by_device.setdefault(one["device"], []).append(f"{one['parameter']} of {one['configuration']}")
    named = "; ".join(f"{device} ({', '.join(which)})" for device, which in by_device.items())
    return f"Deviating from the other devices: {named}."


def members_csv(comparisons: Sequence[Comparison]) -> str:
    """Lay out every device's value of every parameter as CSV, with a header.

    Parameters
    ----------
    comparisons
        Comparison of each parameter of the devices.

    Returns
    -------
    str
        One line a device and parameter.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([
        "device", "configuration", "parameter", "unit", "value", "std", "lower_95", "upper_95", "status",
        "median_of_devices", "spread_of_devices", "z", "limit", "deviates",
    ])  # fmt: skip
    for one in comparisons:
        for m in one.members:
            writer.writerow([
                m.device, one.configuration, one.parameter, one.unit, m.value, m.std, m.lower, m.upper, m.status,
                one.median, one.spread, m.z, one.limit, m.deviates,
            ])  # fmt: skip
    return stream.getvalue()
