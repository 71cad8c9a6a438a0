"""Continuing an interrupted run: what an existing ``identification.json`` holds of the same inputs."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import Configuration
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.errors import InputError

CODE = ("identification", "model", "measurement")


def inputs_digest(
    campaign: Campaign,
    device: Device | None,
    configurations: tuple[Configuration, ...],
    options: FitOptions,
    kind: str,
) -> str:
    """Return sixteen hex digits of everything that the fits depend on: data, device, choices, code."""
    digest = hashlib.sha256()
    parts = options.but(workers=1, quiet=True), kind, campaign.device, campaign.parameter_overrides, repr(device)
    digest.update(repr((parts, campaign.friction)).encode())
    for configuration in configurations:
        digest.update(repr((configuration.free_joints, configuration.posture)).encode())
        for run in configuration.runs:
            digest.update(repr((run.file, run.use, run.hold, run.score_from)).encode())
            for array in (run.t, run.u, run.y, run.v, run.noise, run.resolution):
                digest.update(b"" if array is None else array.tobytes())
    for path in sorted(_sources()):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _sources() -> list[Path]:
    root = Path(__file__).parents[2]
    return [p for package in CODE for p in (root / package).rglob("*") if p.suffix in (".py", ".c", ".h")]


def kept_entries(path: Path, digest: str) -> list[dict[str, Any]]:
    """Return the finished configurations of an earlier run with the same inputs; none where it ran to its end."""
    try:
        data = read_identification(path)
    except InputError:  # nothing to go on from: the run begins anew and writes the file again
        return []
    if data.get("inputs") != digest or data.get("complete", True):
        return []
    return list(data["configurations"])
