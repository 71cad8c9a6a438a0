"""Run all benchmarks one after the other, show what each prints, then what each took and all stored figures."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import threading
import time
from pathlib import Path

import click

FOLDER = Path(__file__).resolve().parent
ROOMS = ("models", "posteriors", "search")
"""Folders whose scripts run one by one, beside those of this folder."""


def names() -> list[str]:
    """List the scripts beside this one and in the rooms, and the folders that run as one."""
    scripts = [p.stem for p in FOLDER.glob("*.py") if p.stem not in ("__init__", "run")]
    scripts += [f"{room}.{p.stem}" for room in ROOMS for p in (FOLDER / room).glob("*.py")]
    return sorted([*scripts, *(p.parent.name for p in FOLDER.glob("*/__main__.py"))])


def measured(name: str, limit: float) -> tuple[str, float, float]:
    """Run one script; return its outcome, wall time [s] and the peak memory of its own process [MB]."""
    start = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-m", f"benchmarks.{name}"], cwd=FOLDER.parent)
    timer = threading.Timer(limit, process.kill)
    timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    code = process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.perf_counter() - start
    outcome = "done" if code == 0 else f"stopped after {limit:.0f} s" if wall > limit else f"failed ({code})"
    return outcome, wall, usage.ru_maxrss / 1024


@click.command()
@click.argument("only", nargs=-1)
@click.option("--limit", default=3600.0, show_default=True, help="Longest time of one benchmark [s].")
def main(only: tuple[str, ...], limit: float) -> None:
    """Run the benchmarks named, or all of them, which takes hours; exit 1 where one fails or is stopped."""
    unknown = sorted(set(only) - set(names()))
    if unknown:
        msg = f"no benchmark {', '.join(unknown)}; there are {', '.join(names())}"
        raise click.BadParameter(msg)
    rows = []
    for name in only or names():
        click.echo(f"== {name}")
        sys.stdout.flush()
        rows.append((name, *measured(name, limit)))
        click.echo()
    click.echo(f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}")
    click.echo(f"{'benchmark':34s}{'outcome':22s}{'wall s':>8s}{'peak MB':>10s}")
    for name, outcome, wall, peak in rows:
        click.echo(f"{name:34s}{outcome:22s}{wall:8.1f}{peak:10.0f}")
    click.echo("\nAll performance figures, as they are stored (docs/results/performance.md):")
    sys.stdout.flush()
    subprocess.run([sys.executable, "-m", "benchmarks.performance", "--table"], cwd=FOLDER.parent, check=True)
    sys.exit(any(outcome != "done" for _, outcome, _, _ in rows))


if __name__ == "__main__":
    main()
