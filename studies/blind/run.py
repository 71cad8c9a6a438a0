"""Blind study of the search for missing effects: make cases, work through them, score: ``python -m studies.blind.run``.

Only the scoring opens the labels. It also decides which effect to leave out of the catalogue in the second pass, where
the right answer is that something unlisted is missing, and adds the proposed run to the cases that were ambiguous.
The study enters the ledger before the search sees its first case, and stays in it however it ends.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.model.effects.effect import match_parameters
from haptid.model.effects.registry import catalogue
from haptid.support.command import exit_codes
from haptid.support.errors import InputError
from haptid.support.files.files import write_json
from haptid.support.terminal import Count
from studies.blind.outcome import MEANING, Outcome, score_case
from studies.blind.score import summary
from studies.blind.settle import with_run
from studies.blind.stranger import score_stranger
from studies.blind.study import ROOT, Job, digest, has_result_of, make, work_all
from studies.ledger.entries import LEDGER, begin_study, end_study
from studies.ledger.generator import generator_digest
from studies.ledger.version import git_version

SCHEMA = "blind/1"
SCORES: dict[str, Callable[..., Outcome]] = {"own": score_case, "stranger": score_stranger}
"""How a case is scored, by the machine that hides."""
WEIGHTS = {"found": 0.65, "without": 0.25, "settled": 0.1}
"""Shares of the time within which jobs of the passes are begun; a pass that is not asked for leaves its to the rest."""


@click.command(help=__doc__)
@click.option(
    "--out", type=click.Path(path_type=Path, file_okay=False), default=Path("artifacts/blind"), show_default=True
)
@click.option("--cases", type=click.IntRange(min=1), default=400, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option(
    "--truth", type=click.Choice(list(SCORES)), default="own", show_default=True,
    help="Machine that hides: with the catalogue's formulas, or a stranger with others, by the whole catalogue alone.",
)  # fmt: skip
@click.option("--kinds", default="", metavar="KIND,KIND", help="none, single, pair, scatter, scatter_with, unlisted.")
@click.option("--sizes", default="", metavar="SIZE,SIZE", help="nominal, small, threshold.")
@click.option("--inputs", type=click.Choice(["rich", "table3", "mixed"]), default="mixed", show_default=True)
@click.option("--effects", default="", metavar="ID,ID", help="Hide no others than these.")
@click.option("--without", default="", metavar="ID,ID", help="Entries that the catalogue lacks in every case.")
@click.option(
    "--whole/--no-whole", default=True, show_default=True, help="Work through all cases with the whole catalogue."
)
@click.option(
    "--leave-out/--no-leave-out", default=True, show_default=True, help="Single effects without their true entry."
)
@click.option(
    "--settle/--no-settle", default=True, show_default=True, help="Make the proposed runs of ambiguous cases."
)
@click.option("--minutes", type=float, default=None, help="Begin no case later than this; score what was finished.")
@click.option("--limit", type=float, default=1800.0, show_default=True, help="Longest processor time for one case [s].")
@click.option("--workers", type=click.IntRange(min=1), default=os.cpu_count() or 1, show_default="cores")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@click.option(
    "--ledger",
    type=click.Path(path_type=Path, dir_okay=False),
    default=LEDGER,
    show_default="docs/results/ledger.json",
    help="Where the study is entered; its results go beside it.",
)
@exit_codes
def main(
    out: Path,
    *,
    whole: bool,
    leave_out: bool,
    settle: bool,
    minutes: float | None,
    workers: int,
    ledger: Path,
    **choices: Any,
) -> None:
    """Make, enter, work through, score."""
    out, began = out.resolve(), time.monotonic()
    asked = {name: choices[name] for name in ("cases", "seed", "kinds", "sizes", "inputs", "effects")}
    if choices["truth"] != "own":  # the other passes know the formulas of the catalogue
        asked, leave_out, settle = {**asked, "truth": choices["truth"]}, False, False
    bar: Any
    with Count(total=choices["cases"], title="cases made", quiet=choices["quiet"]) as bar:
        names = make(out, asked, workers, lambda made: bar.update(made - bar.n))
    lacks = tuple(part for part in choices["without"].split(",") if part)
    jobs = [Job(case=name, campaign=out / "cases" / name, out=out / "found" / name, without=lacks) for name in names]
    asked_for = {"found": whole, "without": leave_out, "settled": settle and whole}
    study = _Passes(out, began, minutes, workers, choices, asked_for)
    told = {"command": _command(), "date": time.strftime("%Y-%m-%d"), "git": git_version(), "code": digest()}
    passes = [name for name, wanted in asked_for.items() if wanted]
    plan = {**asked, "without": choices["without"], "passes": passes, "limit_s": choices["limit"]}
    name = begin_study(ledger, out, plan, {**told, "generator": generator_digest()})

    def store() -> None:
        machine = _about_the_machine(began, workers)
        stored = {"schema": SCHEMA, **told, **machine, "asked": asked, **study.as_json()}
        write_json(out / "blind.json", stored)
        end_study(ledger, name, stored, complete=study.complete)

    try:
        _work_through(study, jobs, asked_for)
    except BaseException:
        store()  # an interrupted study stays in the ledger with what it worked through
        raise
    store()
    if not study.worked_through:
        raise InputError("--minutes", expected="time for one case at least", got=f"{minutes}")
    page = subprocess.run([sys.executable, "-m", "studies.blind.page", str(out / "blind.json")], cwd=ROOT, check=False)
    sys.exit(page.returncode)


def _about_the_machine(began: float, workers: int) -> dict[str, Any]:
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    return {"machine": machine, "wall_s": time.monotonic() - began, "workers": workers}


class _Passes:
    """The three passes over the cases share labels, time and workers, and keep what was worked through."""

    def __init__(
        self,
        out: Path,
        began: float,
        minutes: float | None,
        workers: int,
        choices: dict[str, Any],
        asked_for: dict[str, bool],
    ) -> None:
        read = json.loads((out / "labels.json").read_text(encoding="utf-8"))["labels"]
        self.labels = {label["case"]: label for label in read}
        self.out, self.began, self.minutes, self.workers, self.choices = out, began, minutes, workers, choices
        self.shares = shares([name for name, wanted in asked_for.items() if wanted])
        self.done: dict[str, list[Outcome]] = {"found": [], "without": [], "settled": []}
        self.open = set(self.shares)

    def score_jobs(self, jobs: Sequence[Job], name: str) -> list[Outcome]:
        """Work through the jobs of one pass and score those that were begun in time, or before an interruption."""
        until = float("inf") if self.minutes is None else self.began + 60.0 * self.minutes * self.shares[name]
        stamp = digest()
        bar: Any
        try:
            with Count(total=len(jobs), title=name, quiet=self.choices["quiet"]) as bar:
                work_all(
                    jobs, seed=self.choices["seed"], workers=self.workers, limit=self.choices["limit"], until=until,
                    tell=bar.update,
                )  # fmt: skip
        finally:
            done = [job for job in jobs if has_result_of(job, stamp)]
            score = SCORES[self.choices["truth"]]
            self.done[name] = [
                score(self.labels[job.case], job.result(), left_out=job.without, reason=job.failure() or "")
                for job in done
            ]
        if len(done) == len(jobs):
            self.open.discard(name)
        return self.done[name]

    @property
    def complete(self) -> bool:
        """Whether every job of every pass that was asked for is worked through."""
        return not self.open

    @property
    def worked_through(self) -> int:
        """Number of cases, with the whole catalogue or else without the true effect."""
        return len(self.done["found"]) or len(self.done["without"])

    def as_json(self) -> dict[str, Any]:
        """Return figures and cases of all passes."""
        first, second, third = self.done["found"], self.done["without"], self.done["settled"]
        return {
            "worked_through": self.worked_through, "meaning": MEANING, **summary(first, second, third),
            "cases": [o.as_json() for o in first], "leave_one_out_cases": [o.as_json() for o in second],
            "settled_cases": [o.as_json() for o in third],
        }  # fmt: skip


def _work_through(study: _Passes, jobs: Sequence[Job], asked_for: Mapping[str, bool]) -> None:
    """Work through the passes in their order: without their true entry only cases that have a verdict with it."""
    first = study.score_jobs(jobs, "found") if asked_for["found"] else []
    if asked_for["without"]:
        done = {o.case for o in first}
        left = [job for job in jobs if job.case in done or not asked_for["found"]]
        study.score_jobs(_without(study.out, left, study.labels), "without")
    if asked_for["settled"]:
        study.score_jobs(with_run(study.out, first), "settled")


def shares(passes: Sequence[str]) -> dict[str, float]:
    """Return by which share of the time the last job of each pass is begun.

    Parameters
    ----------
    passes
        Names of the passes, in their order.

    Returns
    -------
    dict
        Share of the time by pass; the last one's is 1.

    Examples
    --------
    >>> shares(["without"])
    {'without': 1.0}
    """
    ends = np.cumsum([WEIGHTS[name] for name in passes])
    return {name: float(end / ends[-1]) for name, end in zip(passes, ends, strict=True)}


def _without(out: Path, jobs: Sequence[Job], labels: Mapping[str, Any]) -> list[Job]:
    """Return the second pass: single effects well above the threshold, themselves left out of the catalogue."""
    chosen = [j for j in jobs if labels[j.case]["kind"] in ("single", "scatter")]
    return [
        replace(j, out=out / "without" / j.case, without=(*j.without, *with_twins(labels[j.case]["effects"])))
        for j in chosen
        if labels[j.case]["size"] != "threshold"
    ]


def with_twins(ids: Sequence[str]) -> tuple[str, ...]:
    """Return ids of effects, and of those that have the same equations under other names.

    Parameters
    ----------
    ids
        Ids of catalogue effects.

    Returns
    -------
    tuple of str
        These ids first, each id once.

    Examples
    --------
    >>> with_twins(["tendon_slack"])
    ('tendon_slack', 'backlash')
    """
    effects = catalogue().values()
    hidden = [e for e in effects if e.id in ids]
    alike = (other.id for other in effects for e in hidden if match_parameters(e, other) is not None)
    return tuple(dict.fromkeys((*ids, *alike)))


def _command() -> str:
    """Return the command as typed, folders that only say where left out."""
    folders = ("--out", "--ledger")
    told = [a for a in sys.argv[1:] if not a.startswith(folders)]
    places = {sys.argv[k + 1] for k, a in enumerate(sys.argv[:-1]) if a in folders}
    return " ".join(["python -m studies.blind.run", *(a for a in told if a not in places)])


if __name__ == "__main__":
    main()
