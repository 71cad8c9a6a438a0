"""``python -m benchmarks.performance``: measure what grows with what and how long a user waits; store and show it."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

import click

from benchmarks.performance.figures import STORED, all_figures, read_stored
from benchmarks.performance.page import machine_words, text_table, write_page
from benchmarks.performance.waiting import waiting_times
from benchmarks.performance.work import CURVES
from haptid.support.files.files import write_json
from haptid.support.installing.environment import ROOT

PACKAGES = ("numpy", "scipy", "sympy", "pandas", "fmpy")


def measure_curve(name: str) -> dict[str, Any]:
    """Measure each size of a curve in a process of its own; the curve says when, at which commit and load."""
    curve, points = CURVES[name], []
    for size in curve.sizes:
        command = [sys.executable, "-m", "benchmarks.performance.work", name, str(size)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        points.append(json.loads(done.stdout.splitlines()[-1]))
        click.echo(f"{curve.title}: {size} {curve.axis}, {points[-1]['cpu_s']:.2f} s of processor", err=True)
    return {"title": curve.title, "axis": curve.axis, "points": points, **when()}


def when() -> dict[str, Any]:
    """Return date, commit and load of a measurement: curves that stay stored keep theirs."""
    return {"date": datetime.now(UTC).date().isoformat(), "commit": commit(), "load": os.getloadavg()[0]}


def commit() -> str:
    """Return the commit that is measured."""
    done = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or "unknown"


@click.command()
@click.option("--curve", "names", multiple=True, type=click.Choice(list(CURVES)), help="Only this; others stay stored.")
@click.option("--waiting", is_flag=True, help="Measure only how long a user waits; the curves stay stored.")
@click.option("--table", is_flag=True, help="Measure nothing: print the table and write the page of what is stored.")
def main(names: tuple[str, ...], waiting: bool, table: bool) -> None:
    """Measure, store, write the page, and print one table of all performance figures."""
    stored = read_stored(STORED.name)
    if not table:
        curves = {} if stored is None else stored["curves"]
        measured = {name: measure_curve(name) for name in names or (() if waiting else CURVES)}
        stored = {
            "command": f"python -m benchmarks.performance {' '.join(sys.argv[1:])}".strip(),
            **when(),
            "machine": f"{os.cpu_count()} cores, {platform.machine()}",
            "versions": {"Python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
            "waiting_s": waiting_times(),
            "curves": {name: (curves | measured)[name] for name in CURVES if name in curves | measured},
        }
        write_json(STORED, stored)
    if stored is not None:
        write_page(stored)
        click.echo(machine_words(stored))
    click.echo(text_table(all_figures()))


if __name__ == "__main__":
    main()
