"""Sample the posteriors of a campaign's joints: `Job` in, `Sampled` joint after joint out.

1. Take the fit that an identification left in the folder of the results, or make one.
2. Sample the posterior from there.
3. Say where the posterior contradicts the fit, and refuse a posterior that is not finite.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.sequence.step import Step
from haptid.identification.workers.watched import Watched
from haptid.identification.workers.workers import Workers
from haptid.measurement.checks.preparation import tell_remarks
from haptid.support.listener import Listener
from haptid.support.processes.threads import single_threaded
from haptid.uq.job.job import Job
from haptid.uq.result.agreement import word_disagreement, word_misfit
from haptid.uq.result.finite import check_finite, early_word
from haptid.uq.result.full_model import as_fit
from haptid.uq.result.infer import infer
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.subject import Subject, find_subject


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
    for number, configuration in enumerate(configurations):
        joint = configuration.free_joints[0]
        stages = _Stages(listener=listener, joint=joint, number=number, count=len(configurations))
        yield single_threaded(_sample_joint, job, configuration, pool, stages)


def _sample_joint(job: Job, configuration: Configuration, pool: Workers, stages: _Stages) -> Sampled:
    joint, runs = configuration.free_joints[0], configuration.runs
    equations = equations_for(job.campaign, job.device, (joint,), configuration.posture)
    early = early_word(equations, runs, joint, job.campaign.folder)
    if early:
        stages.listener.note(f"warning: {early}")
    stages.tell("fit", 0.0, "")
    subject = find_subject(
        job.campaign, job.device, configuration, equations, job.out,
        kind=job.kind, seed=job.options.sampling.seed, workers=Watched(workers=pool, tell=partial(stages.tell, "fit")),
    )  # fmt: skip
    found = subject.fit
    posterior = infer(
        subject.simulator,
        subject.runs,
        np.array(found.theta),
        job.options,
        joint=joint,
        workers=pool,
        folder=job.out / "posterior" / f"joint{joint}.chains",
        tell=stages.tell,
        forward=subject.forward,
        share_of_steps=subject.share_of_steps,
    )
    doubts = tuple(d for d in (word_misfit(found), word_disagreement(found, posterior.parameters)) if d)
    for doubt in doubts:
        stages.listener.note(f"warning: joint {joint}: {doubt}")
    notes = notes_of(posterior, subject, early=early, doubts=doubts)
    posterior = check_finite(replace(posterior, notes=notes, doubts=doubts))
    return Sampled(step=Step(configuration=configuration, fit=as_fit(found, posterior)), posterior=posterior)


def notes_of(posterior: Posterior, subject: Subject, *, early: str, doubts: Sequence[str]) -> tuple[str, ...]:
    """Gather what the reader of a posterior is told, what forbids to use it first.

    Parameters
    ----------
    posterior
        Posterior of the joint.
    subject
        The fit that it starts from.
    early
        What was said before any work; empty where nothing was.
    doubts
        Why the intervals are not to be used yet.

    Returns
    -------
    tuple of str
        Sentences.
    """
    found = subject.fit
    first = [early] if early else []
    shortened = [f"{posterior.shortened.capitalize()}."] if posterior.shortened else []
    source = f"The fit it starts from, {subject.source}: {found.outcome.value}."
    return (*first, *reversed(doubts), *shortened, *found.notes, *found.warnings, source)


SHARES = {"fit": (0.0, 0.08), "noise model": (0.08, 0.18), "sampling": (0.18, 0.8), "diagnostics": (0.8, 1.0)}
"""Shares of a joint's work between which each stage is thought to lie, for those who wait [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stages:
    """Progress of one joint: the stage that it is in, and how far that is."""

    listener: Listener
    joint: int
    number: int
    count: int

    def tell(self, stage: str, share: float | None, figures: str) -> None:
        begin, end = SHARES[stage]
        done = self.number + begin + (share or 0.0) * (end - begin)
        title = f"joint {self.joint} ({self.number + 1} of {self.count}): {stage}"
        # Without a share no end is foretold: the time left would only grow.
        self.listener.progress(title, done, None if share is None else self.count, figures)
