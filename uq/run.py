"""Posterior of every joint's parameters: ``python -m uq.run [CAMPAIGN]``."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from haptid.fmu_build.accuracy.draws import digest_of
from haptid.fmu_build.accuracy.stored_draws import DRAWS_OF_POSTERIOR, POSTERIOR
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.optimise.workers import Processes, Submitting
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.configurations import Configuration, configurations_of
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.sequence.resume import data_digest
from haptid.identification.sequence.step import Step
from haptid.identification.verification.result import Verification
from haptid.measurement.checks.preparation import campaign_for_command, tell_remarks
from haptid.measurement.format.devices import device_of
from haptid.measurement.format.reading import is_foreign
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.report.common.stored_page import write_page
from haptid.report.discrepancy.full_model_section import full_model_sections
from haptid.report.posterior.foreign_page import foreign_posterior_page
from haptid.report.posterior.page import posterior_page
from haptid.support.command import parse_joints, progress, word_command
from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.processes.threads import single_threaded
from haptid.uq.commands import posterior as main
from haptid.uq.foreign.infer import QUICK as FOREIGN_QUICK
from haptid.uq.foreign.infer import SAMPLING as FOREIGN_SAMPLING
from haptid.uq.foreign.infer import infer as infer_foreign
from haptid.uq.foreign.record import posterior_json
from haptid.uq.foreign.record import save_chains as save_foreign_chains
from haptid.uq.foreign.record import save_draws as save_foreign_draws
from haptid.uq.foreign.record import summary_text as summary_of_foreign
from haptid.uq.foreign.source import holds_calibration, read_calibrated
from haptid.uq.result.agreement import word_disagreement
from haptid.uq.result.finite import check_finite, early_word, with_null
from haptid.uq.result.full_model import as_fit, full_model_bands
from haptid.uq.result.infer import QUICK, InferOptions, infer
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.record import SCHEMA, as_json, save_chains, save_draws
from haptid.uq.result.subject import find_subject
from haptid.uq.sampling.sampling import SamplingOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class _Command:
    """Settings of the command, read from the command line and the campaign."""

    campaign: Campaign
    device: Device | None
    out: Path
    options: InferOptions
    kind: Kind | None
    quiet: bool


@dataclass(slots=True)
class _Results:
    """Results of the joints that are finished so far."""

    posteriors: list[Posterior] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    full: Verification = field(default_factory=lambda: Verification(runs=()))


def sample_campaign(campaign: Path | None, **settings: Any) -> dict[str, Any]:
    """Sample the posterior of every joint, and write and tell the result.

    Parameters
    ----------
    campaign
        Folder with campaign.toml; None for the embedded Freedom 6S campaign.
    settings
        Options of the command by name.

    Returns
    -------
    dict
        Content of posterior.json.
    """
    if holds_calibration(campaign) or is_foreign(campaign):
        return _infer_foreign(campaign, **settings)
    read = campaign_for_command(campaign)
    device = device_of(read)
    sampling = replace(QUICK if settings["quick"] else SamplingOptions(), seed=settings["seed"])
    command = _Command(
        campaign=read,
        device=device,
        out=settings["out"],
        options=InferOptions(sampling=sampling, noise_given=read.noise_given, sensitivity=settings["sensitivity"]),
        kind=None if settings["kind"] == "none" else settings["kind"],
        quiet=settings["quiet"],
    )
    results = _Results()
    configurations = _configurations(read, device, parse_joints(settings["joints"]))
    with workers_of(settings["scheduler"], settings["workers"]) as pool:
        tell_remarks(read)
        for configuration in configurations:
            fitted, posterior = single_threaded(_one, command, configuration, pool)
            results.posteriors.append(posterior)
            results.steps.append(Step(configuration=configuration, fit=as_fit(fitted, posterior)))
            save_chains(posterior, command.out / "posterior" / f"joint{posterior.joint}.nc", measured=read.measured)
            data = _write(command, results)
            click.echo(_summary(posterior))
    if device is not None:
        results.full = full_model_bands(read, device, results.steps, seed=sampling.seed)
        data = _write(command, results)
    return data


def _infer_foreign(campaign: Path | None, **settings: Any) -> dict[str, Any]:
    """Sample the posterior of a calibrated FMU: CAMPAIGN is the folder of its results, or --out holds them."""
    if settings["joints"] is not None:
        raise InputError("--joints", expected="no such option for an FMU", got=repr(settings["joints"]))
    folder = campaign if campaign is not None and holds_calibration(campaign) else settings["out"]
    chosen = click.get_current_context().get_parameter_source("out") is not ParameterSource.DEFAULT
    out, seed = settings["out"] if chosen else folder, settings["seed"]
    calibrated = read_calibrated(folder)
    options = replace(FOREIGN_QUICK if settings["quick"] else FOREIGN_SAMPLING, seed=seed)
    bar: Any
    with (
        ForeignFmu(calibrated.campaign.model, limit_s=settings["limit_s"]) as fmu,
        workers_of(settings["scheduler"], settings["workers"]) as pool,
        progress(total=options.longest, title=fmu.path.name, quiet=settings["quiet"]) as bar,
    ):

        def report(steps: int, tau: float, effective: float) -> None:
            bar.n = steps
            bar.set_postfix_str(f"τ {tau:.1f}, ESS {effective:.0f}")

        posterior = single_threaded(infer_foreign, calibrated, fmu, options, pool, report)
    data = with_null(posterior_json(posterior, seed))
    write_json(out / "posterior.json", data)
    save_foreign_draws(posterior, out / "parameters_posterior.csv", seed)
    save_foreign_chains(posterior, out / "posterior" / "model.nc")
    made_by = f"{word_command('posterior', 'uq.run')}, seed {seed}, {time.strftime('%Y-%m-%d')}"
    write_page(out / "posterior.html", foreign_posterior_page(posterior, [made_by, calibrated.campaign.title]))
    click.echo(summary_of_foreign(posterior))
    return data


def workers_of(scheduler: str | None, count: int) -> AbstractContextManager[Submitting]:
    """Return the workers of a command.

    Parameters
    ----------
    scheduler
        Address of a running Dask scheduler; processes on this machine where None.
    count
        Number of processes on this machine.
    """
    if scheduler is None:
        return Processes(count)
    from haptid.identification.optimise.dask_workers import Cluster  # noqa: PLC0415 (slow to import and rarely needed)

    return Cluster(scheduler)


def _configurations(
    campaign: Campaign, device: Device | None, wanted: tuple[int, ...] | None
) -> tuple[Configuration, ...]:
    """Return the configurations of one free joint, in locking order, each joint in the first posture of its runs.

    Raises
    ------
    InputError
        Where no run to fit has exactly one free joint.
    """
    single: dict[tuple[int, ...], Configuration] = {}
    for one in configurations_of(campaign, device, wanted):
        if len(one.free_joints) == 1:
            single.setdefault(one.free_joints, one)
    if not single:
        raise InputError(str(campaign.folder), expected="a run to fit with one free joint", got="none")
    return tuple(single.values())


def _one(command: _Command, configuration: Configuration, pool: Submitting) -> tuple[Fit, Posterior]:
    joint, runs = configuration.free_joints[0], configuration.runs
    sampling = command.options.sampling
    equations = equations_for(command.campaign, command.device, (joint,), configuration.posture)
    early = early_word(equations, runs, joint, command.campaign.folder)
    if early:
        click.echo(f"warning: {early}", err=True)
    bar: Any
    with progress(total=sampling.longest, title=f"joint {joint}: fit", quiet=command.quiet) as bar:
        subject = find_subject(
            command.campaign, command.device, configuration, equations, command.out,
            kind=command.kind, seed=sampling.seed, workers=pool,
        )  # fmt: skip
        found = subject.fit

        def report(steps: int, tau: float, effective: float) -> None:
            bar.n = steps
            bar.set_postfix_str(f"τ {tau:.1f}, ESS {effective:.0f}")

        posterior = infer(
            subject.simulator,
            subject.runs,
            np.array(found.theta),
            command.options,
            joint=joint,
            workers=pool,
            folder=command.out / "posterior" / f"joint{joint}.chains",
            report=report,
            say=lambda what: bar.set_description(f"joint {joint}: {what}"),
            forward=subject.forward,
        )
    notes = (*found.notes, *found.warnings, f"The fit it starts from, {subject.source}: {found.outcome.value}.")
    contradiction = word_disagreement(found, posterior.parameters)
    if contradiction:
        click.echo(f"warning: joint {joint}: {contradiction}", err=True)
        notes = (contradiction, *notes)
    return found, check_finite(replace(posterior, notes=(early, *notes) if early else notes))


def _write(command: _Command, results: _Results) -> dict[str, Any]:
    """Write the files of all finished joints; it runs after each joint, so that an interrupted command keeps them."""
    campaign, out, posteriors = command.campaign, command.out, results.posteriors
    seed = command.options.sampling.seed
    head = {
        "schema": SCHEMA,
        "device": campaign.device,
        "campaign": campaign.title,
        "measured": campaign.measured,
        "seed": seed,
        "intervals": "equal-tailed",
    }
    drawn = save_draws(posteriors, out / DRAWS_OF_POSTERIOR, np.random.default_rng([seed, 5]))
    digests = [data_digest(campaign, command.device, step.configuration) for step in results.steps]
    joints = [as_json(p, digest) for p, digest in zip(posteriors, digests, strict=True)]
    draws = digest_of(drawn.read_bytes())
    data = with_null({**head, "draws": draws, "joints": joints, "full_model": results.full.as_json()})
    write_json(out / POSTERIOR, data)
    footer = [f"{word_command('posterior', 'uq.run')}, seed {seed}, {time.strftime('%Y-%m-%d')}", campaign.title]
    page = posterior_page(
        posteriors,
        title="How well the parameters are known",
        synthetic=not campaign.measured,
        footer=footer,
        full=full_model_sections(results.full),
    )
    write_page(out / "posterior.html", page)
    return data


def _summary(posterior: Posterior) -> str:
    sample = posterior.sample
    lines = [f"joint {posterior.joint} ({posterior.chosen.model.words})"]
    lines += [f"  {p.verdict}" for p in posterior.parameters]
    known = "settled" if sample.reached else "the chain is too short to settle it: final figures without --quick"
    lines.append(
        f"  sampler: τ {sample.tau.max():.1f} steps ({known}), R̂ {posterior.worst_rhat:.3f}, "
        f"ESS {min(p.diagnostics.ess_bulk for p in posterior.parameters):.0f}, {posterior.wall_s:.0f} s"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
