"""What changes when a threshold is halved or doubled? ``python -m studies.thresholds.run``.

Each case of a fixed panel is run as delivered, and once more for each threshold that it reads, halved and doubled.
What is finished stays in the JSON: the same command goes on from there.
"""

from __future__ import annotations

import json
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.errors import InputError, NumericalError
from haptid.support.terminal import Count
from studies.blind.study import PACKAGES, digest
from studies.ledger.version import store
from studies.thresholds.one_run import Run, end_runs, run_apart
from studies.thresholds.outcome import cost_ratio, differences
from studies.thresholds.page import headline, page
from studies.thresholds.panel import PANEL, Case
from studies.thresholds.values import FACTORS, ROOMS, Threshold, all_thresholds

SCHEMA = "thresholds/1"
OF_CODE = (*PACKAGES, "uq", "virtual_device", "studies/hidden")
"""Packages whose code decides an outcome."""


@click.command(help=__doc__)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("artifacts/thresholds/thresholds.json"),
    show_default=True,
    help="JSON; a page of the same name with .md goes beside it.",
)
@click.option(
    "--campaigns",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("artifacts/thresholds/cases"),
    show_default=True,
    help="Folder of the panel's campaigns, made anew for a new study.",
)
@click.option("--only", default="", metavar="ROOM", help=f"Change thresholds of one room: {', '.join(ROOMS)}.")
@click.option("--minutes", type=float, default=None, help="Begin no run later than this.")
@click.option("--limit", type=float, default=300.0, show_default=True, help="Longest time for one run [s].")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True)
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
def main(
    out: Path, campaigns: Path, *, only: str, minutes: float | None, limit: float, workers: int, quiet: bool
) -> None:
    """Run, write, summarise."""
    if only and not any(_within(room, only) for room in ROOMS):
        raise InputError("--only", expected=f"one of {', '.join(ROOMS)}", got=repr(only))
    study = Study(
        out=out, campaigns=campaigns, panel=PANEL, limit_s=limit, workers=workers, quiet=quiet, minutes=minutes
    )
    study.begin()
    study.deliver()
    study.change(only)
    click.echo(headline(study.stored))
    click.echo(f"written: {out}, {out.with_suffix('.md').name}")


def _within(room: str, asked: str) -> bool:
    return room == asked or room.startswith(f"{asked}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A run that is to be made: a case under a changed threshold.

    Parameters
    ----------
    case
        Case of the panel.
    threshold
        Threshold that is changed.
    change
        ``halved`` or ``doubled``.
    """

    case: Case
    threshold: Threshold
    change: str


@dataclass(slots=True, kw_only=True)
class Study:
    """The study so far; its JSON and page are written after every run.

    Parameters
    ----------
    out
        JSON file.
    campaigns
        Folder of the panel's campaigns.
    panel
        Cases.
    limit_s
        Longest duration of a run [s].
    workers
        Runs at a time.
    minutes
        Time after which no run begins; None for all.
    quiet
        Whether progress stays unsaid.
    stored
        Content of the JSON.
    began
        When this command began, by `time.monotonic` [s].
    before_s
        Duration of the earlier commands of the study [s].
    """

    out: Path
    campaigns: Path
    panel: Sequence[Case]
    limit_s: float = 300.0
    workers: int = 1
    minutes: float | None = None
    quiet: bool = True
    stored: dict[str, Any] = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)
    before_s: float = 0.0

    def begin(self) -> None:
        """Read what is finished, or begin anew.

        Raises
        ------
        InputError
            Where the file holds a study of other code, cases or thresholds.
        """
        same = {
            "schema": SCHEMA,
            "code": digest(OF_CODE),
            "panel": [case.as_json() for case in self.panel],
            "thresholds": [threshold.as_json() for threshold in all_thresholds()],
        }
        if self.out.exists():
            self.stored = json.loads(self.out.read_text(encoding="utf-8"))
            plain = json.loads(json.dumps(same))
            if lost := [name for name in plain if self.stored.get(name) != plain[name]]:
                todo = "choose another --out, or remove that file"
                raise InputError(str(self.out), expected=f"a study of the same {lost[0]}", got="another one", todo=todo)
            self.before_s = self.stored["wall_s"]
            return
        self.stored = same | {"delivered": {}, "changes": {}}

    def deliver(self) -> None:
        """Run each case as delivered, once noting what it reads and once without; make its campaign before.

        Raises
        ------
        NumericalError
            Where a case has no outcome, or another one the second time.
        """
        left = [case for case in self.panel if case.name not in self.stored["delivered"]]
        bar: Any
        with Count(total=len(left), title="as delivered", quiet=self.quiet) as bar:
            for case in self.panel:
                folder = self.folder(case)
                if case in left or not (folder / "campaign.toml").exists():
                    module, _, name = case.make.partition(":")
                    getattr(import_module(module), name)(folder, **case.hidden)
                if case not in left:
                    continue
                noted = run_apart(Run(case=case, campaign=folder, note=True), self.limit_s)
                plain = run_apart(Run(case=case, campaign=folder), self.limit_s)
                self.stored["delivered"][case.name] = _join_notes(case.name, noted, plain)
                self.keep()
                bar.update()

    def change(self, only: str = "") -> None:
        """Run what is not finished, cases of short runs first.

        Parameters
        ----------
        only
            A room, or a package with all its rooms; all where empty.
        """
        changes = [one for one in self.changes() if not only or _within(one.threshold.room, only)]
        left = iter([one for one in changes if not self._is_finished(one)])
        bar: Any
        with (
            Count(total=len(changes), title="changes", quiet=self.quiet) as bar,
            ThreadPoolExecutor(self.workers) as pool,
        ):
            bar.update(sum(map(self._is_finished, changes)))
            try:
                self._work_off(left, pool, bar.update)
            except BaseException:
                end_runs()  # the pool waits for them
                raise
        self.keep()

    def changes(self) -> list[Change]:
        """List all changes of thresholds that cases read, in the order in which they are run.

        The cases follow each other as in the panel. What modules take over as they load, whether a case needs it or
        not, comes after all that the cases read as they work.

        Returns
        -------
        list of Change
            A change of each threshold that a case reads, halved and doubled, where that is another value.
        """
        delivered = self.stored["delivered"]
        known = {threshold.key: threshold for threshold in all_thresholds()}
        return [
            Change(case=case, threshold=known[key], change=change)
            for reads in ("read", "read_as_loaded")
            for case in self.panel
            for key in delivered[case.name][reads]
            for change in FACTORS
            if known[key].scale_value(change) is not None
        ]

    def folder(self, case: Case) -> Path:
        """Name the folder of a case's campaign.

        Parameters
        ----------
        case
            Case of the panel.

        Returns
        -------
        Path
            Folder below ``campaigns``.
        """
        return self.campaigns / case.name.replace(" ", "_")

    def keep(self) -> None:
        """Write JSON and page."""
        self.stored |= {
            "command": " ".join(["python -m studies.thresholds.run", *sys.argv[1:]]),
            "date": time.strftime("%Y-%m-%d"),
            "machine": f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}",
            "workers": self.workers,
            "limit_s": self.limit_s,
            "wall_s": round(self.before_s + time.monotonic() - self.began, 1),
            "planned": len(self.changes()) if len(self.stored["delivered"]) == len(self.panel) else None,
        }
        store(self.out, self.stored, page)

    def _run(self, one: Change) -> Run:
        value = one.threshold.scale_value(one.change)
        assert value is not None  # others are not planned
        name, room = one.threshold.name, one.threshold.room
        return Run(case=one.case, campaign=self.folder(one.case), room=room, name=name, value=value)

    def _work_off(self, left: Iterator[Change], pool: ThreadPoolExecutor, tell: Callable[[], object]) -> None:
        """Run changes as workers become free, until none is left or the time is over."""
        running: dict[Future[dict[str, Any]], Change] = {}
        while True:
            while len(running) < self.workers and not self._is_over() and (one := next(left, None)):
                running[pool.submit(run_apart, self._run(one), self.limit_s)] = one
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                self._finish(running.pop(future), future.result())
                tell()

    def _finish(self, one: Change, outcome: dict[str, Any]) -> None:
        before = self.stored["delivered"][one.case.name]
        told = {"differences": differences(before, outcome), "cost": cost_ratio(before, outcome), "outcome": outcome}
        self.stored["changes"].setdefault(one.threshold.key, {}).setdefault(one.change, {})[one.case.name] = told
        self.keep()

    def _is_finished(self, one: Change) -> bool:
        return one.case.name in self.stored["changes"].get(one.threshold.key, {}).get(one.change, {})

    def _is_over(self) -> bool:
        return self.minutes is not None and time.monotonic() - self.began > 60.0 * self.minutes


def _join_notes(name: str, noted: dict[str, Any], plain: dict[str, Any]) -> dict[str, Any]:
    """Return the delivered outcome with what was read, where both runs came to the same."""
    if "failed" in plain or "failed" in noted:
        msg = f"case {name!r} as delivered: {plain.get('failed', noted.get('failed'))}"
        raise NumericalError(msg)
    if unlike := [key for key in plain if key != "wall_s" and plain[key] != noted[key]]:
        msg = f"case {name!r} as delivered: {unlike[0]} differs from one run to the next"
        raise NumericalError(msg)
    return {**noted, "wall_s": plain["wall_s"]}


if __name__ == "__main__":
    main()
