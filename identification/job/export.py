"""Export all models of an identification: `Identification` in, FMUs and parameter set below a folder out."""

from __future__ import annotations

from pathlib import Path

from haptid.fmu_build.building.packaging import Fmu, Kind
from haptid.fmu_build.export import export_full, export_joint, export_parameters
from haptid.identification.job.job import Identification
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.verification.closed_loop_fmu import export_closed_loop
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.support.files.files import write_json
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
        joints = [step.configuration.free_joints[0] for step in made.steps]
        return [
            export_joint(data, j, folder / f"joint{j}{tail}.fmu", kind, folder=folder).path
            for j in joints
            for kind, tail in KINDS
        ]
    if not data["links"]:
        return []
    name = Path(device.name).stem

    def build(kind: Kind, tail: str) -> Fmu:
        return export_full(device, data, folder / f"{name}{tail}.fmu", kind, folder=folder)

    # Each waits for the C compiler, which runs in processes of its own.
    fmus = map_threads(build, *zip(*KINDS, strict=True), threads=made.workers)
    loop = export_closed_loop(fmus[-1], campaign.extra.get("controller"), campaign.runs, made.verification, folder)
    if loop is not None:
        data["verification"]["as_fmus"] = loop.as_json()
        write_json(folder / FILE, data)
    paths = [fmu.path for fmu in fmus] + ([loop.controller, loop.system] if loop else [])
    return [*paths, export_parameters(device, data, folder / "parameters.ssv")]
