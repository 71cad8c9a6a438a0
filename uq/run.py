"""Posterior of every joint's parameters: ``python -m uq.run [CAMPAIGN]``."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from identification.equations_for import device_of, equations_for
from identification.fitting import fit
from identification.options import FitOptions
from identification.workers import Processes, Submitting, single_threaded
from measurement.campaign import Campaign
from measurement.prepare import campaign_for_command
from report.posterior_page import posterior_page
from support.command import common_options, exit_codes, parse_joints, progress
from support.errors import InputError
from support.files import write_json, write_text
from uq.forward import kernel_of
from uq.infer import QUICK, InferOptions, infer
from uq.posterior import Posterior
from uq.record import SCHEMA, as_json, save_chains, save_draws
from uq.sampling import SamplingOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class _Command:
    """What the command line said."""

    campaign: Campaign
    out: Path
    options: InferOptions
    quiet: bool


@click.command(help=__doc__)
@click.argument("campaign", required=False, type=click.Path(path_type=Path))
@common_options
@click.option("--quick", is_flag=True, help="A short chain: under a minute a joint; says that it is short.")
@click.option("--sensitivity", is_flag=True, help="Also with all priors half and twice as wide.")
@exit_codes
def main(campaign: Path | None, **settings: Any) -> None:
    """Sample, write, summarise."""
    read = campaign_for_command(campaign)
    joints = _joints(read, parse_joints(settings["joints"]))
    sampling = replace(QUICK if settings["quick"] else SamplingOptions(), seed=settings["seed"])
    options = InferOptions(sampling=sampling, noise_given=read.noise_given, sensitivity=settings["sensitivity"])
    command = _Command(campaign=read, out=settings["out"], options=options, quiet=settings["quiet"])
    posteriors: list[Posterior] = []
    with workers_of(settings["scheduler"], settings["workers"]) as pool:
        for joint in joints:
            posterior = single_threaded(_one, command, joint, pool)
            posteriors.append(posterior)
            save_chains(posterior, command.out / "posterior" / f"joint{joint}.nc", measured=read.measured)
            _write(command, posteriors)
            click.echo(_summary(posterior))


def workers_of(scheduler: str | None, count: int) -> AbstractContextManager[Submitting]:
    """Return processes here, or a running Dask cluster."""
    if scheduler is None:
        return Processes(count)
    from identification.dask_workers import Cluster  # noqa: PLC0415 (slow to import and rarely needed)

    return Cluster(scheduler)


def _joints(campaign: Campaign, wanted: tuple[int, ...] | None) -> tuple[int, ...]:
    """Return the joints to sample; each needs a run to fit."""
    fitted = tuple(j for j in campaign.joints if campaign.runs_of((j,), "fit"))
    for joint in wanted or ():
        if joint not in fitted:
            raise InputError("--joints", expected=f"joints with a run to fit, of {fitted}", got=str(joint))
    if not fitted:
        raise InputError(str(campaign.folder), expected="a run to fit with one free joint", got="none")
    return wanted or fitted


def _one(command: _Command, joint: int, pool: Submitting) -> Posterior:
    campaign, sampling = command.campaign, command.options.sampling
    equations = equations_for(campaign, device_of(campaign), (joint,))
    simulator = kernel_of(equations)
    runs = campaign.runs_of((joint,))
    bar: Any
    with progress(total=sampling.longest, title=f"joint {joint}: fit", quiet=command.quiet) as bar:
        found = fit(simulator, runs, options=FitOptions(seed=sampling.seed), workers=pool)

        def report(steps: int, tau: float, effective: float) -> None:
            bar.n = steps
            bar.set_postfix_str(f"τ {tau:.1f}, ESS {effective:.0f}")

        posterior = infer(
            simulator,
            runs,
            np.array(found.theta),
            command.options,
            joint=joint,
            workers=pool,
            folder=command.out / "posterior" / f"joint{joint}.chains",
            report=report,
            say=lambda what: bar.set_description(f"joint {joint}: {what}"),
        )
    return replace(posterior, notes=(*found.notes, *found.warnings, f"The fit it starts from: {found.outcome.value}."))


def _write(command: _Command, posteriors: list[Posterior]) -> None:
    """Write what all finished joints share, so that an interrupted command keeps it."""
    campaign, out = command.campaign, command.out
    seed = command.options.sampling.seed
    head = {
        "schema": SCHEMA,
        "device": campaign.device,
        "campaign": campaign.title,
        "measured": campaign.measured,
        "seed": seed,
        "intervals": "equal-tailed",
    }
    write_json(out / "posterior.json", {**head, "joints": [as_json(p) for p in posteriors]})
    save_draws(posteriors, out / "parameters_posterior.csv", np.random.default_rng([seed, 5]))
    footer = [f"python -m uq.run, seed {seed}, {time.strftime('%Y-%m-%d')}", campaign.title]
    page = posterior_page(
        posteriors, title="How well the parameters are known", synthetic=not campaign.measured, footer=footer
    )
    write_text(out / "posterior.html", page)


def _summary(posterior: Posterior) -> str:
    sample = posterior.sample
    lines = [f"joint {posterior.joint} ({posterior.chosen.model.words})"]
    lines += [f"  {p.verdict}" for p in posterior.parameters]
    known = "known" if sample.reached else "not known yet"
    lines.append(
        f"  sampler: τ {sample.tau.max():.1f} steps ({known}), R̂ {posterior.worst_rhat:.3f}, "
        f"ESS {min(p.diagnostics.ess_bulk for p in posterior.parameters):.0f}, {posterior.wall_s:.0f} s"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
