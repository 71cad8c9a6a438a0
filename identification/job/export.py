"""Export all models of an identification: `Identification` in, FMUs and parameter set below a folder out."""

from __future__ import annotations

from pathlib import Path

from haptid.fmu_build.building.packaging import Fmu, Kind
from haptid.fmu_build.content.references import PARAMETER_SET
from haptid.fmu_build.exchange.archive import unpack
from haptid.fmu_build.export import export_full, export_joint, export_parameters
from haptid.identification.job.job import Identification
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.verification.closed_loop_fmu import export_closed_loop
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.files.files import write_bytes, write_json
from haptid.support.processes.threads import map_threads

KINDS: tuple[tuple[Kind, str], ...] = (("python", ""), ("native", "_native"))
"""Packagings, and what they add to the name of the file."""


def export_models(made: Identification, campaign: Campaign, device: Device | None, folder: Path) -> list[Path]:
    """Export the whole device, or the single joints, in both packagings, and the parameter set.

    Parameters
    ----------
    made
        Identification whose draws lie below ``folder``.
    campaign
        Campaign with the controller of the whole device, if any.
    device
        Device of the campaign; None for a single joint.
    folder
        Folder of the results.

    Returns
    -------
    list of Path
        Files that were written; none where the device was not identified as a whole.

    Raises
    ------
    InputError, WritingError
        Where the folder cannot be written, or the reference run of a model overflows.
    """
    data = made.data
    if device is None:
        return _export_single_joints(made, folder)
    if not data["links"]:
        return []
    name = Path(device.name).stem

    def build(kind: Kind, tail: str) -> Fmu:
        return export_full(device, data, folder / f"{name}{tail}.fmu", kind, folder=folder)

    # Each waits for the C compiler, which runs in processes of its own.
    built = map_threads(build, *zip(*KINDS, strict=True), threads=made.workers)
    loop = export_closed_loop(built[-1], campaign.extra.get("controller"), campaign.runs, made.verification, folder)
    if loop is not None:
        data["verification"]["as_fmus"] = loop.as_json()
        write_json(folder / FILE, data)
    written = [fmu.path for fmu in built] + ([loop.controller, loop.system] if loop else [])
    return [*written, export_parameters(device, data, folder / "parameters.ssv")]


def _export_single_joints(made: Identification, folder: Path) -> list[Path]:
    """Export every joint that was identified without a device, each with its parameter set beside it."""
    paths: list[Path] = []
    for step in made.steps:
        (joint,) = step.configuration.free_joints
        fmus = []
        for kind, tail in KINDS:
            path = folder / f"joint{joint}{tail}.fmu"
            fmus.append(export_joint(made.data, joint, path, kind, folder=folder))
        paths += [*(fmu.path for fmu in fmus), _write_parameter_set(fmus[0])]
    return paths


def _write_parameter_set(fmu: Fmu) -> Path:
    """Write the parameter set that an FMU holds beside it, where an editor finds it."""
    return write_bytes(fmu.path.with_suffix(".ssv"), unpack(fmu.path.read_bytes())[PARAMETER_SET])
