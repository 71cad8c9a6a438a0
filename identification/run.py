"""``python -m identification.run [CAMPAIGN]``: fits in locking order, coupled test, verification, export."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

from haptid.fmu_build.accuracy.draws import COUNT
from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Kind
from haptid.fmu_build.exchange.ssv import write_ssv
from haptid.fmu_build.export import export_full, export_joint, export_parameters
from haptid.identification.baseline.prediction import predict_unseen
from haptid.identification.calibration.calibrate import calibrate
from haptid.identification.calibration.result_json import calibration_json
from haptid.identification.calibration.start_values import write_with_starts
from haptid.identification.calibration.words import summary_text as summary_of_calibration
from haptid.identification.commands import identify as main
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.optimise.dask_workers import Cluster
from haptid.identification.optimise.workers import Here, Processes, Workers
from haptid.identification.output.summary import summary_text
from haptid.identification.output.traces import traces_of
from haptid.identification.output.written_draws import write_draws
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.configurations import Configuration, configurations_of
from haptid.identification.sequence.result_json import SCHEMA, step_json
from haptid.identification.sequence.resume import code_digest, data_digest, inputs_digest, kept_entries
from haptid.identification.sequence.sequence import Build, Sequence
from haptid.identification.sequence.step import Step
from haptid.identification.sequence.whole_device import Whole, whole_device
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.identification.verification.closed_loop_fmu import export_closed_loop
from haptid.identification.verification.result import Verification
from haptid.identification.verification.verify import verify
from haptid.measurement.checks.preparation import campaign_for_command, tell_remarks
from haptid.measurement.format.devices import device_of
from haptid.measurement.format.foreign_campaign import read_foreign_campaign
from haptid.measurement.format.reading import is_foreign
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.warning import warnings_on_stderr
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.report.common.stored_page import write_page
from haptid.report.identification.foreign_page import calibration_page
from haptid.report.identification.page import identification_page
from haptid.support.command import parse_joints, progress, word_command
from haptid.support.errors import InputError
from haptid.support.files.files import write_json

PACKAGES = ("numpy", "scipy", "sympy", "fmpy", "pythonfmu", "ziglang")
"""Packages whose versions are written to identification.json."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Inputs of one call of the command.

    Parameters
    ----------
    campaign
        Campaign with the runs.
    device
        Device of the campaign; None for a single joint.
    configurations
        Configurations to fit, in order.
    options
        Choices of the fits.
    kind
        Packaging of the FMU that the fits run; None runs the kernel in process.
    out
        Folder of the results.
    scheduler
        Address of a Dask scheduler; None runs in this process or in processes of this machine.
    """

    campaign: Campaign
    device: Device | None
    configurations: tuple[Configuration, ...]
    options: FitOptions
    kind: Kind | None
    out: Path
    scheduler: str | None

    @property
    def build(self) -> Build:
        """Function from equations to the simulator that runs the fits."""
        kind = self.kind

        def through_fmu(equations: Equations) -> Simulator:
            return (
                FmuSimulator.of(identification_fmu(equations, kind=kind), equations) if kind else in_process(equations)
            )

        return through_fmu

    @property
    def file(self) -> Path:
        """File of the results."""
        return self.out / "identification.json"


def in_process(equations: Equations) -> Simulator:
    """Build the simulator that runs the compiled kernel in this process.

    Parameters
    ----------
    equations
        Equations without observer.

    Returns
    -------
    Simulator
        `KernelSimulator` with the default inner step.
    """
    return KernelSimulator.of(equations)


def identify_campaign(  # noqa: PLR0913 # one argument an option
    campaign: str | None,
    out: Path,
    joints: str | None,
    scheduler: str | None,
    *,
    kind: str,
    no_export: bool,
    model: Path | None,
    limit_s: float,
    **choices: Any,
) -> dict[str, Any]:
    """Identify a device from a campaign, and write and tell the result.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    out
        Folder of the results.
    joints
        Numbers of the joints, separated by commas; None for all.
    scheduler
        Address of a Dask scheduler; None runs here.
    kind
        Packaging that the fits run: ``python``, ``native`` or ``none``.
    no_export
        Whether the FMUs of the whole device are left out.
    model
        FMU to calibrate; None where the campaign does not name the variables of one, or names it itself.
    limit_s
        Longest wait for one simulation of an FMU [s].
    choices
        Fields of `FitOptions`.

    Returns
    -------
    dict
        Content of identification.json.
    """
    if model is not None or is_foreign(campaign):
        for name, value in (("--joints", joints), ("--scheduler", scheduler)):
            if value is not None:
                raise InputError(name, expected="no such option for an FMU", got=repr(value), todo="leave it out")
        return _calibrate(campaign, model, out, FitOptions(**choices), limit_s)
    read = campaign_for_command(campaign)
    device = device_of(read)
    options = FitOptions(**choices)
    job = Job(
        campaign=read,
        device=device,
        configurations=configurations_of(read, device, parse_joints(joints)),
        options=options,
        kind=None if kind == "none" else kind,  # type: ignore[arg-type] # click has checked the choice
        out=out,
        scheduler=scheduler,
    )
    steps, data = _fit_configurations(job)
    whole, verification = _whole(job, steps)
    data |= {"links": _links_json(whole), "verification": verification.as_json()}
    data["whole"] = dict(whole.values) if whole else {}
    name = device.name if device else ""
    data["draws"] = write_draws(steps, whole, job.out, name=name, seed=options.seed)
    write_json(job.file, data)
    exported = [] if no_export else _export(job, data, verification)
    traces = [traces_of(step, job.build) for step in steps]
    predictions = [predict_unseen(step.compared) for step in steps]
    page = identification_page(read.title, steps, traces, predictions, data, verification)
    write_page(job.out / "report.html", page)
    data["complete"] = True
    write_json(job.file, data)
    click.echo(summary_text(steps, data["verification"]))
    click.echo(f"written below {job.out}: identification.json, report.html" + "".join(f", {p.name}" for p in exported))
    return data


def _calibrate(
    campaign: str | None, model: Path | None, out: Path, options: FitOptions, limit_s: float
) -> dict[str, Any]:
    """Calibrate an FMU, write its results, and return the content of identification.json."""
    if campaign is None:
        raise InputError("CAMPAIGN", expected="the folder of a campaign about the FMU", got="none")
    with warnings_on_stderr():
        read = read_foreign_campaign(campaign, model)
    with ForeignFmu(read.model, limit_s=limit_s) as fmu:
        bar: Any
        with progress(total=options.starts, title=read.model.name, quiet=options.quiet) as bar:

            def report(done: int) -> None:
                bar.n = done
                bar.refresh()

            calibration = calibrate(read, fmu, options, report)
    data = calibration_json(calibration, _provenance(options), out)
    write_json(out / "identification.json", data)
    write_page(out / "report.html", calibration_page(calibration, data))
    write_with_starts(read.model, out / "identified.fmu", calibration.values)
    # The units of an FMU may be no units of a parameter set: each value is in its variable's own.
    write_ssv(out / "parameters.ssv", calibration.values, dict.fromkeys(calibration.values, ""))
    click.echo(summary_of_calibration(calibration))
    click.echo(f"written below {out}: identification.json, report.html, identified.fmu, parameters.ssv")
    return data


def _fit_configurations(job: Job) -> tuple[tuple[Step, ...], dict[str, Any]]:
    """Fit every configuration; the results so far are on disk after each."""
    digest = inputs_digest(job.campaign, job.device, job.configurations, job.options, str(job.kind))
    entries = kept_entries(job.file, digest)
    data = _head(job, digest)
    steps: list[Step] = []
    with _workers(job) as workers:
        tell_remarks(job.campaign)
        sequence = Sequence(
            campaign=job.campaign,
            device=job.device,
            build=job.build,
            options=job.options,
            workers=workers,
            kept=dict(enumerate(entries)),
        )
        bar: Any = progress(total=len(job.configurations), title=job.configurations[0].name, quiet=job.options.quiet)
        with bar:
            for step in sequence.steps(job.configurations):
                steps.append(step)
                source = data_digest(job.campaign, job.device, step.configuration)
                data["configurations"].append({**step_json(step), "data": source})
                # After every configuration: an interrupted command is continued from the finished ones.
                write_json(job.file, data)
                bar.update()
                if len(steps) < len(job.configurations):
                    bar.set_description(job.configurations[len(steps)].name)
    return tuple(steps), data


@contextmanager
def _workers(job: Job) -> Iterator[Workers]:
    if job.scheduler is not None:
        with Cluster(job.scheduler) as cluster:
            yield cluster
    elif job.options.workers == 1:
        yield Here()
    else:
        with Processes(job.options.workers) as pool:
            yield pool


def _provenance(options: FitOptions) -> dict[str, Any]:
    """Return seed, versions and command."""
    software = {name: _version(name, "not installed") for name in PACKAGES}
    command = word_command("identify", "identification.run")
    # Below haptid the command's own name is the first argument.
    arguments = sys.argv[2:] if command.startswith("haptid") else sys.argv[1:]
    return {
        "seed": options.seed,
        "software": {"haptid": _version("haptid", "from source"), "python": platform.python_version(), **software},
        "command": " ".join((command, *arguments)),
    }


def _head(job: Job, digest: str) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "device": job.campaign.device,
        "campaign": job.campaign.title,
        "measured": job.campaign.measured,
        "remarks": list(job.campaign.remarks),
        **_provenance(job.options),
        "code": code_digest().hex()[:16],
        "inputs": digest,
        "complete": False,
        "locking_order": [list(joints) for joints in dict.fromkeys(c.free_joints for c in job.configurations)],
        "configurations": [],
        "links": {},
        "verification": {"runs": []},
    }


def _version(name: str, otherwise: str) -> str:
    try:
        return version(name)
    except ModuleNotFoundError:
        return otherwise


def _whole(job: Job, steps: tuple[Step, ...]) -> tuple[Whole | None, Verification]:
    """Combine the steps and verify the whole model, where every joint of the device was tested."""
    device = job.device
    if device is None or {j for step in steps for j in step.configuration.free_joints} != set(
        range(len(device.joints))
    ):
        return None, Verification(runs=())
    whole = whole_device(device, steps, seed=job.options.seed, draws=COUNT)
    controller = job.campaign.extra.get("controller")
    unseen = [run for run in job.campaign.runs if run.use == "validate"]
    return whole, verify(
        device, whole.values, unseen, controller, draws=whole.draws[: THRESHOLDS.draws_of_whole_device]
    )


def _links_json(whole: Whole | None) -> dict[str, Any]:
    if whole is None:
        return {}
    return {
        link: {
            id: {"value": one.value, "std": one.std, "unit": one.unit, "status": one.status}
            for id, one in table.items()
        }
        for link, table in whole.links.links.items()
    }


def _export(job: Job, data: dict[str, Any], checks: Verification) -> list[Path]:
    """Export the whole device, or the single joint, as FMUs and a parameter set."""
    kinds: tuple[tuple[Kind, str], ...] = (("python", ""), ("native", "_native"))
    if job.device is None:
        joints = [c.free_joints[0] for c in job.configurations]
        return [
            export_joint(data, j, job.out / f"joint{j}{tail}.fmu", kind, folder=job.out).path
            for j in joints
            for kind, tail in kinds
        ]
    if not data["links"]:
        return []
    name = Path(job.device.name).stem
    made = [export_full(job.device, data, job.out / f"{name}{tail}.fmu", kind, folder=job.out) for kind, tail in kinds]
    loop = export_closed_loop(made[-1], job.campaign.extra.get("controller"), job.campaign.runs, checks, job.out)
    if loop is not None:
        data["verification"]["as_fmus"] = loop.as_json()
        write_json(job.file, data)
    paths = [fmu.path for fmu in made] + ([loop.controller, loop.system] if loop else [])
    return [*paths, export_parameters(job.device, data, job.out / "parameters.ssv")]


if __name__ == "__main__":
    main()
