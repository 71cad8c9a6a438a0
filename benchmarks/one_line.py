"""The readme's one line with a cold cache: seconds and peak memory of the set-up, the FMUs, the fits and the rest.

``--install`` makes a clone and an empty virtual environment too, and counts the installation (needs the network).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import click

from haptid.support.installing.environment import ROOT


def timed(command: Sequence[str | Path], folder: Path, cache: Path) -> tuple[float, float]:
    """Run a command; return wall seconds and the peak memory of its largest process [MB]."""
    environment = {**os.environ, "HAPTID_CACHE": str(cache)}
    start = time.perf_counter()
    process = subprocess.Popen([str(c) for c in command], cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(map(str, command))} left with {process.returncode}")
    return time.perf_counter() - start, usage.ru_maxrss / 1024


def row(what: str, seconds: float, peak: float | None = None) -> None:
    """Print one row of the table."""
    print(f"{what:34s}{seconds:8.1f} s" + (f"{peak:8.0f} MB" if peak else ""), flush=True)


@click.command()
@click.option("--install", is_flag=True, help="From a clone and an interpreter without packages.")
def main(*, install: bool) -> None:
    """Time the stages one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        project, python = ROOT, Path(sys.executable)
        if install:
            project, python = base / "clone", base / "python" / "bin" / "python"
            subprocess.run(["git", "clone", "--quiet", ROOT, project], check=True)
            subprocess.run([sys.executable, "-m", "venv", base / "python"], check=True)
            row("installation", *timed([python, "support/bootstrap.py", "-m", "this"], project, base / "cache"))
        out = base / "artifacts"
        fmus: list[str | Path] = [python, "-m", "fmu_build.run", "--quiet", "--out", out]
        row("derivation and FMUs, cold", *timed(fmus, project, base / "cache"))
        row("derivation and FMUs, cached", *timed(fmus, project, base / "cache"))
        fits: list[str | Path] = [python, "-m", "identification.run", "--quiet", "--out", out]
        wall, peak = timed(fits, project, base / "cache")
        made = json.loads((out / "identification.json").read_text(encoding="utf-8"))["configurations"]
        for one in made:
            row(f"  fit of {one['free_joints']}, {one['simulations']} simulations", one["wall_s"])
        fitting = sum(one["wall_s"] for one in made)
        row("all fits", fitting)
        row("verification, export, report", wall - fitting)
        row("identification.run altogether", wall, peak)


if __name__ == "__main__":
    main()
