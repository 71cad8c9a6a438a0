"""Continuing an interrupted run: digest of its inputs and existing ``identification.json`` in, finished entries out."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

from haptid.fmu_build.exchange.identification_json import read_identification
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import Configuration
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.errors import InputError

CODE = ("identification", "model", "measurement")
"""Packages whose source files enter the digest."""


def inputs_digest(
    campaign: Campaign,
    device: Device | None,
    configurations: tuple[Configuration, ...],
    options: FitOptions,
    kind: str,
) -> str:
    """Compute a digest of data, device, choices and code, which the fits depend on.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configurations
        Configurations to fit, with their runs.
    options
        Choices of the fits.
    kind
        Packaging of the FMU that the fits run.

    Returns
    -------
    str
        Sixteen hexadecimal digits of the SHA-256.
    """
    digest = hashlib.sha256()
    # Neither the number of workers nor the progress bar changes a result: a run may be continued with others.
    digest.update(repr((options.but(workers=1, quiet=True), kind)).encode())
    for configuration in configurations:
        digest.update(data_digest(campaign, device, configuration).encode())
    return digest.hexdigest()[:16]


def data_digest(campaign: Campaign, device: Device | None, configuration: Configuration) -> str:
    """Compute a digest of what one configuration is fitted to: its runs, the device, the user's entries, and the code.

    Parameters
    ----------
    campaign
        Campaign with parameter entries and friction laws.
    device
        Device of the campaign; None for a single joint.
    configuration
        Free joints, posture and runs.

    Returns
    -------
    str
        Sixteen hexadecimal digits of the SHA-256.
    """
    digest = hashlib.sha256(code_digest())
    digest.update(repr((campaign.device, campaign.parameter_overrides, repr(device), campaign.friction)).encode())
    digest.update(repr(campaign.drives).encode())
    digest.update(repr((configuration.free_joints, configuration.posture)).encode())
    for run in configuration.runs:
        digest.update(repr((run.file, run.use, run.hold, run.score_from, run.averaged_rows)).encode())
        for array in (run.t, run.u, run.inputs, run.y, run.v, run.noise, run.resolution):
            digest.update(b"" if array is None else array.tobytes())
    return digest.hexdigest()[:16]


@cache
def code_digest() -> bytes:
    """Compute the digest of the source files of the packages in `CODE`.

    Returns
    -------
    bytes
        SHA-256 over the contents in the order of the paths, 32 bytes.
    """
    digest = hashlib.sha256()
    for path in sorted(_sources()):
        digest.update(path.read_bytes())
    return digest.digest()


def _sources() -> list[Path]:
    root = Path(__file__).parents[2]
    return [p for package in CODE for p in (root / package).rglob("*") if p.suffix in (".py", ".c", ".h")]


def kept_entries(path: Path, digest: str) -> list[dict[str, Any]]:
    """Read the finished configurations of an interrupted run.

    Parameters
    ----------
    path
        File identification.json of the earlier run.
    digest
        Digest of the present inputs, as `inputs_digest` returns it.

    Returns
    -------
    list of dict
        Entries of ``configurations`` in order; none where the file cannot be read, its inputs differ, or that run was
        complete.
    """
    try:
        data = read_identification(path)
    except InputError:  # nothing to go on from: the run begins anew and writes the file again
        return []
    if data.get("inputs") != digest or data.get("complete", True):
        return []
    return list(data["configurations"])
