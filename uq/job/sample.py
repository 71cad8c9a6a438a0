"""Sample the posteriors of a campaign's joints: `Job` in, `Sampled` joint after joint out.

1. Take the fit that an identification left in the folder of the results, or make one.
2. Sample the posterior from there.
3. Say where the posterior contradicts the fit, and refuse a posterior that is not finite.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.fmu_build.building.cached import identification_fmu
from haptid.identification.fit.multistart import fit
from haptid.identification.optimise.workers import Workers
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.carried_fit import FILE, carried_fit
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.equations_for import equations_for, name_campaign_in_errors
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.checks.preparation import tell_remarks
from haptid.model.equations.equations import Equations
from haptid.support.listener import Listener
from haptid.support.processes.threads import single_threaded
from haptid.uq.density.forward import kernel_of
from haptid.uq.job.job import Job
from haptid.uq.result.agreement import word_disagreement
from haptid.uq.result.finite import check_finite, early_word
from haptid.uq.result.full_model import as_fit
from haptid.uq.result.infer import infer
from haptid.uq.result.posterior import Posterior


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampled:
    """A joint whose posterior was sampled.

    Parameters
    ----------
    step
        Its configuration, with mean and covariance of the posterior as the fit.
    posterior
        Its posterior.
    """

    step: Step
    posterior: Posterior


def sample_joints(
    job: Job, configurations: Sequence[Configuration], pool: Workers, listener: Listener
) -> Iterator[Sampled]:
    """Sample one joint after the other.

    Parameters
    ----------
    job
        What to sample, and how.
    configurations
        Configurations of one free joint each.
    pool
        Workers of fit and sampler.
    listener
        Told of remarks on the data, of each step, and of warnings.

    Yields
    ------
    Sampled
        In the order of ``configurations``.

    Raises
    ------
    InputError
        Where a configuration has no free parameter.
    NumericalError
        Where a posterior is not finite, or a fit fails.
    """
    tell_remarks(job.campaign, listener)
    for configuration in configurations:
        yield single_threaded(_sample_joint, job, configuration, pool, listener)


def _sample_joint(job: Job, configuration: Configuration, pool: Workers, listener: Listener) -> Sampled:
    joint, runs = configuration.free_joints[0], configuration.runs
    equations = equations_for(job.campaign, job.device, (joint,), configuration.posture)
    early = early_word(equations, runs, joint, job.campaign.folder)
    if early:
        listener.note(f"warning: {early}")
    stages = _Stages(listener=listener, joint=joint, longest=job.options.sampling.longest)
    stages.enter("fit")
    found, source = _take_fit(job, configuration, equations, pool)
    posterior = infer(
        # The ranges of the fit: those that haptid chose may have been widened to hold its optimum.
        _simulator(job, found.equations),
        runs,
        np.array(found.theta),
        job.options,
        joint=joint,
        workers=pool,
        folder=job.out / "posterior" / f"joint{joint}.chains",
        report=stages.report,
        say=stages.enter,
        through_simulator=job.kind is not None,
    )
    notes = (*found.notes, *found.warnings, f"The fit it starts from, {source}: {found.outcome.value}.")
    contradiction = word_disagreement(found, posterior.parameters)
    if contradiction:
        listener.note(f"warning: joint {joint}: {contradiction}")
        notes = (contradiction, *notes)
    posterior = check_finite(replace(posterior, notes=(early, *notes) if early else notes))
    return Sampled(step=Step(configuration=configuration, fit=as_fit(found, posterior)), posterior=posterior)


@dataclass(slots=True, kw_only=True)
class _Stages:
    """Progress of one joint: the stage that it is in, and the steps of its chains."""

    listener: Listener
    joint: int
    longest: int
    stage: str = ""

    def enter(self, stage: str) -> None:
        self.stage = stage
        self.listener.progress(f"joint {self.joint}: {stage}", 0, self.longest)

    def report(self, steps: int, tau: float, effective: float) -> None:
        figures = f"τ {tau:.1f}, ESS {effective:.0f}"
        self.listener.progress(f"joint {self.joint}: {self.stage}", steps, self.longest, figures)


def _take_fit(
    job: Job, configuration: Configuration, equations: Equations, pool: Workers
) -> tuple[Fit, str]:  # fmt: skip
    """Return the fit of the configuration, and where it is from."""
    found = carried_fit(job.campaign, job.device, configuration, equations, job.out)
    if found is not None:
        return found, f"read from {FILE}"
    options = FitOptions(seed=job.options.sampling.seed)
    with name_campaign_in_errors(job.campaign, configuration.free_joints):
        return fit(kernel_of(equations), configuration.runs, options=options, workers=pool), "made here"


def _simulator(job: Job, equations: Equations) -> Simulator:
    if job.kind is None:
        return kernel_of(equations)
    return FmuSimulator.of(identification_fmu(equations, kind=job.kind), equations)
