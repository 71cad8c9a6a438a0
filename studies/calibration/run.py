"""Do the printed intervals cover? Simulation-based calibration: ``python -m studies.calibration.run``."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.workers.workers import Processes
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.format.devices import device_of
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.noise.noise_model import NoiseModel
from haptid.noise.thresholds import THRESHOLDS
from haptid.support.command import exit_codes, parse_joints
from haptid.support.errors import InputError
from haptid.support.terminal import Count
from studies.calibration.result import judge_ranks, page, table
from studies.calibration.simulation_based import Design, Outcome, rank_one_set
from studies.ledger.version import git_version, store

PRIOR = 0.1
"""Relative width of the priors from which truths are drawn."""
KEPT_EVERY = 10
"""Data sets between one writing of the results and the next."""
PRIOR_WORDS = (
    f"normal, {PRIOR:.0%} wide (1e-4 about 0); cycle_scatter half-normal, scale 10 %; noise_factor log-normal, "
    f"{THRESHOLDS.stated_noise_log_std:.0%} wide"
)


@click.command(help=__doc__)
@click.option("--joints", default="0,4", show_default=True, help="A base and a tendon joint.")
@click.option("--sets", type=click.IntRange(min=1), default=200, show_default=True, help="Data sets per joint.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("docs/results/calibration.json"),
    show_default=True,
    help="JSON; a page of the same name with .md goes beside it.",
)
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
def main(joints: str, sets: int, seed: int, workers: int, out: Path, *, quiet: bool) -> None:
    """Calibrate, write, summarise."""
    campaign = campaign_for_command(None)
    chosen = parse_joints(joints) or ()
    known = [j for j in chosen if j in campaign.joints]
    if known != list(chosen):
        raise InputError("--joints", expected=f"joints of {campaign.joints}", got=joints)
    study = _Study(
        command=f"python -m studies.calibration.run --joints {joints} --sets {sets} --seed {seed}",
        workers=workers,
        out=out,
    )
    with Processes(workers) as pool:
        for joint in chosen:
            design = design_of(campaign, joint)
            tasks = [(design, k, seed) for k in range(sets)]
            bar: Any
            with Count(total=sets, title=f"joint {joint}", quiet=quiet) as bar:

                def more(done: Sequence[Outcome], bar: Any = bar, joint: int = joint, design: Design = design) -> int:
                    bar.update(len(done) - bar.n)
                    if done and (len(done) % KEPT_EVERY == 0 or len(done) == sets):
                        study.keep(joint, design, done)
                    return sets - len(done)

                pool.until(rank_one_set, tasks, more)
            click.echo(table(str(joint), study.results[str(joint)]))


@dataclass(slots=True, kw_only=True)
class _Study:
    """What is known so far, written whenever more is known: an interrupted command keeps it."""

    command: str
    workers: int
    out: Path
    begun: float = field(default_factory=time.perf_counter)
    results: dict[str, dict[str, Any]] = field(default_factory=dict)

    def keep(self, joint: int, design: Design, outcomes: Sequence[Outcome]) -> None:
        """Judge the outcomes of a joint so far and write everything."""
        self.results[str(joint)] = {"design": design.words, **judge_ranks(outcomes, names_of(design))}
        stored = {
            "command": self.command,
            "date": time.strftime("%Y-%m-%d"),
            "git": git_version(),
            "python": sys.version.split()[0],
            "workers": self.workers,
            "wall_s": time.perf_counter() - self.begun,
            "priors": PRIOR_WORDS,
            "joints": self.results,
        }
        store(self.out, stored, page)


def design_of(campaign: Campaign, joint: int) -> Design:
    """Design data sets like a joint's runs, with normal priors around its first guesses.

    Parameters
    ----------
    campaign
        Campaign with runs of the joint.
    joint
        Number of the joint.

    Returns
    -------
    Design
        Amplitude and frequency of the first three runs for fitting; amplitude scatter in the readings.
    """
    equations = with_priors(equations_for(campaign, device_of(campaign), (joint,)))
    runs = campaign.runs_of((joint,), "fit")[:3]
    torques = tuple((float(np.ptp(run.u)) / 2, _omega(run.t, run.u[:, 0])) for run in runs)
    return Design(equations=equations, model=NoiseModel(scatter="reading"), torques=torques)


def _omega(t: Array, u: Array) -> float:
    """Angular frequency from the zero crossings of a cosine [rad/s]."""
    signs = np.flatnonzero(np.diff(np.sign(u)) != 0)
    return float(np.pi * (len(signs) - 1) / (t[signs[-1]] - t[signs[0]]))


def with_priors(equations: Equations) -> Equations:
    """Put normal priors of relative width ``PRIOR`` around the first guesses; about 0 they are 1e-4 wide.

    Parameters
    ----------
    equations
        Equations of a joint.

    Returns
    -------
    Equations
        With a prior on every free parameter.
    """
    changes: dict[str, dict[str, Any]] = {}
    for q in equations.parameters:
        if not q.fixed:
            width = PRIOR * abs(q.initial) if abs(q.initial) > 1e-6 else 1e-4
            changes[q.id] = {"prior": Normal(mean=q.initial, std=width)}
    return equations.with_parameters(changes)


def names_of(design: Design) -> tuple[str, ...]:
    """Return the coordinates that are ranked.

    Parameters
    ----------
    design
        Design of the data sets.

    Returns
    -------
    tuple of str
        Ids of the free parameters, then of the noise model's.
    """
    hyper = design.model.hyper(noise_width=THRESHOLDS.stated_noise_log_std, travel=0.5)
    return (*(q.id for q in design.equations.parameters if not q.fixed), *(h.id for h in hyper))


if __name__ == "__main__":
    main()
