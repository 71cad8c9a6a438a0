"""Run the first tutorial from top to bottom, and keep its outputs, its times and what it identified.

``python -m docs.from_runs.tutorial_page`` runs the page's blocks ``bash`` and ``python`` in a new folder, each in a
process of its own, as a reader would. It writes what they print into the blocks ``text`` below them, and times and
estimates into the JSON beside the page, from which the tables of the page are made. The tests run the same blocks.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from docs.from_runs.pendulum_tables import TRUTH
from docs.parts.tables import table, with_parts
from haptid.support.files.files import write_json, write_text
from haptid.support.installing.environment import ROOT

PAGE = ROOT / "docs" / "tutorial" / "from_tables_to_fmu.md"
STORED = PAGE.with_suffix(".json")
SCRIPT = "docs/from_runs/tutorial_page.py"
BLOCK = re.compile(r"```(?P<language>bash|python)\n(?P<code>.*?)```(?:\n\n```text\n(?P<shown>.*?)```)?", re.DOTALL)
HEADING = re.compile(r"^## (\d+\. .*)$", re.MULTILINE)
MATCHES = {"weight": "gravity_sin"}
"""Ids of the fit by name of the truth, where they differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """One block that ran.

    Parameters
    ----------
    heading
        Of the section in which it stands.
    shown
        What the page says that it prints.
    printed
        What it printed.
    seconds
        How long it took [s].
    """

    heading: str
    shown: str
    printed: str
    seconds: float


def run_page(folder: Path) -> list[Done]:
    """Run the blocks of the page.

    Parameters
    ----------
    folder
        Empty working folder.

    Returns
    -------
    list of Done
        In the order of the page.

    Raises
    ------
    CalledProcessError
        Where a block fails.
    """
    page = PAGE.read_text(encoding="utf-8")
    environment = reader_environment(folder)
    work = folder / "work"
    (work / "docs").mkdir(parents=True)
    (work / "docs" / "tutorial").symlink_to(PAGE.parent)
    done = []
    for block in BLOCK.finditer(page):
        command = ["bash", "-e", "-c"] if block["language"] == "bash" else [sys.executable, "-c"]
        began = time.perf_counter()
        ran = subprocess.run(
            [*command, block["code"]], cwd=work, env=environment, check=True, text=True, stdout=subprocess.PIPE
        )
        heading = HEADING.findall(page[: block.start()])[-1]
        seconds = time.perf_counter() - began
        done.append(Done(heading=heading, shown=block["shown"] or "", printed=ran.stdout, seconds=seconds))
    return done


def reader_environment(folder: Path) -> dict[str, str]:
    """Return an environment in which ``haptid`` is the command of this clone.

    Parameters
    ----------
    folder
        Place for a folder ``bin``.

    Returns
    -------
    dict
        Variables of the process.
    """
    binaries = folder / "bin"
    binaries.mkdir()
    haptid = binaries / "haptid"
    haptid.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m haptid "$@"\n', encoding="utf-8")
    haptid.chmod(0o755)
    path = os.pathsep.join([str(binaries), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "COLUMNS": "160"}


def with_outputs(page: str, done: Sequence[Done]) -> str:
    """Return the page with what its blocks printed."""
    printed = iter(done)

    def write_block(block: re.Match[str]) -> str:
        one = next(printed)
        if block["shown"] is None:
            return block[0]
        return f"{block[0].partition('```text')[0]}```text\n{one.printed}```"

    return BLOCK.sub(write_block, page)


def estimates_of(folder: Path) -> dict[str, dict[str, Any]]:
    """Return value, standard deviation, unit and status of every parameter that the page's fit found."""
    data = json.loads((folder / "work" / "results" / "identification.json").read_text(encoding="utf-8"))
    parameters = data["configurations"][0]["parameters"]
    return {id: {key: one[key] for key in ("value", "std", "unit", "status")} for id, one in parameters.items()}


def with_tables(page: str, stored: Mapping[str, Any]) -> str:
    """Return the page with its tables of times and of estimates beside the truth."""
    return with_parts(page, {"times": times_table(stored), "truth": truth_table(stored["estimates"])}, SCRIPT)


def times_table(stored: Mapping[str, Any]) -> str:
    """Return how long each step took."""
    rows = [(heading, f"{seconds:.0f} s") for heading, seconds in stored["seconds"].items()]
    total = sum(stored["seconds"].values())
    header = ("step", "time of the computer")
    times = table(header, [*rows, ("all", f"{total:.0f} s")])
    machine = f"{stored['cores']} cores that {stored['load']:.0f} processes shared, empty cache, {stored['date']}"
    return f"{times}\n*Measured on {machine}. What is left of ten minutes is for reading.*"


def truth_table(estimates: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the simulated pendulum's numbers beside the identified ones."""
    rows = []
    for name, true in TRUTH.items():
        found = estimates[MATCHES.get(name, name)]
        deviation = (found["value"] - true) / found["std"]
        rows.append((f"`{MATCHES.get(name, name)}`", f"{true:g}", f"{found['value']:.6g}", f"{found['std']:.2g}",
                     found["unit"], f"{deviation:+.1f}"))  # fmt: skip
    return table(("parameter", "true", "identified", "std", "unit", "deviation in std"), rows)


@click.command()
def main() -> None:
    """Run the page with an empty cache, and store its outputs, times and estimates."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        os.environ["HAPTID_CACHE"] = str(folder / "cache")
        done = run_page(folder)
        seconds: dict[str, float] = {}
        for one in done:
            seconds[one.heading] = round(seconds.get(one.heading, 0.0) + one.seconds, 1)
        stored = {
            "date": datetime.now(UTC).date().isoformat(),
            "cores": os.cpu_count(),
            "load": round(os.getloadavg()[1], 1),
            "seconds": seconds,
            "estimates": estimates_of(folder),
        }
    write_json(STORED, stored)
    write_text(PAGE, with_tables(with_outputs(PAGE.read_text(encoding="utf-8"), done), stored))
    click.echo(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
