"""``python -m tests.fuzz.run`` (``make fuzz``): feed changed files to the readers, store what fails and the result.

The changes are those of the suite, drawn by `random.Random`: in the suite Hypothesis draws them and shortens what
fails, but over a million inputs its own bookkeeping takes longer than most readers.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import resource
import subprocess
import sys
from concurrent.futures import as_completed
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import click

from haptid.support.command import exit_codes
from haptid.support.errors import one_line
from haptid.support.files.files import write_bytes, write_json, write_text
from haptid.support.processes.pool import Pool
from haptid.support.terminal import Count
from tests.fuzz.harness import Fault, Tally, Target, call, drawn
from tests.fuzz.recordings import StandingPool
from tests.fuzz.targets import TARGETS

BATCH = 5000
"""Inputs of one task; each has a seed of its own, so that the same inputs come whatever the number of workers."""
SEEDS = Path(__file__).parent / "seeds"
ROOM = 4 << 30
"""Address space beside what is mapped at the start [bytes]: a reader that runs away fails instead of the machine."""

HEAD = """# Readers under changed files

Valid files with one to four changes (other numbers, broken text, missing and repeated lines, deep nests) must be read
or refused with one printable line, in 5 s of computing time and 500 MiB. A fault is anything else; each was mended
after the run that found it, and its input stays a test.

Of `fmi_calls` (FMI 2.0) and `fmi3_calls` (FMI 3.0) each input is a script of calls in any order with any arguments, on
a native FMU that is compiled with the address and the undefined-behaviour sanitizer (`tests/fuzz/fmi/`): no call that
is refused may change anything, a step that succeeds leaves finite states, and no memory is left.

| reader | inputs | read | faults | longest [s] | memory [MiB] | date, version |
| --- | ---: | ---: | ---: | ---: | ---: | --- |"""


@click.command()
@click.option("--inputs", type=click.IntRange(min=1), default=100_000, show_default=True, help="Inputs a reader.")
@click.option("--target", "names", multiple=True, type=click.Choice(list(TARGETS)), help="Only this; may be repeated.")
@click.option("--seed", "first", type=int, default=0, show_default=True, help="Same seed, same inputs.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), default=Path("docs/results/fuzzing.json"),
              show_default=True, help="Where the result goes.")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=1), default=os.cpu_count() or 1, show_default="cores",
              help="Processes on this machine.")  # fmt: skip
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
def main(inputs: int, names: tuple[str, ...], first: int, out: Path, workers: int, quiet: bool) -> None:
    """Feed changed files to every reader; exit 1 where one does anything but read or refuse in one line.

    Inputs that fail are stored below tests/fuzz/seeds, one for each place that fails; the test suite replays them.
    After each reader the result is written anew.
    """
    results = []
    with Pool(workers) as pool:
        for name in names or TARGETS:
            result = _fuzz(pool, name, inputs, first, quiet)
            results.append(result)
            _write(out, name, result)
            counts = f"{result['inputs']} inputs, {result['read']} read, {len(result['faults'])} faults"
            click.echo(f"{name}: {counts}, worst {result['worst_seconds']} s, {result['peak_growth_mib']} MiB")
    if any(result["faults"] for result in results):
        sys.exit(1)


def _write(out: Path, name: str, result: dict[str, Any]) -> None:
    """Put one reader's result among those that are stored, and write the page of them all."""
    stored = json.loads(out.read_text(encoding="utf-8")) if out.exists() else {"readers": {}}
    stored["readers"][name] = {
        **result,
        "command": f"python -m tests.fuzz.run {' '.join(sys.argv[1:])}".strip(),
        "date": datetime.now(UTC).date().isoformat(),
        "version": _version(),
        "python": sys.version.split()[0],
    }
    write_json(out, stored)
    write_text(out.with_suffix(".md"), page(stored))


def page(stored: dict[str, Any]) -> str:
    """Return the stored results as a page."""
    rows = [
        f"| {name} | {r['inputs']:,} | {r['read']:,} | {len(r['faults'])} | {r['worst_seconds']:.2f} "
        f"| {r['peak_growth_mib']:.0f} | {r['date']}, {r['version']} |"
        for name, r in sorted(stored["readers"].items())
    ]
    faults = [
        f"- {name}: {one_line(fault['place'])}, stored as `{fault['input']}`"
        for name, r in sorted(stored["readers"].items())
        for fault in r["faults"]
    ]
    commands = sorted({r["command"] for r in stored["readers"].values()})
    return "\n".join((HEAD, *rows, "", "Faults, by the line that they passed through:", "", *(faults or ["none"]), "",
                      "Made by:", "", *(f"- `{command}`" for command in commands), ""))  # fmt: skip


def _fuzz(pool: Pool, name: str, inputs: int, first: int, quiet: bool) -> dict[str, Any]:
    parts = [
        pool.submit(fuzz_part, name, f"{name} {first + k}", min(BATCH, inputs - k * BATCH))
        for k in range(-(-inputs // BATCH))
    ]
    with Count(total=inputs, title=name, quiet=quiet) as bar:
        done = []
        for part in as_completed(parts):
            done.append(part.result())
            bar.update(done[-1]["inputs"])
    faults = {fault["place"]: fault for part in done for fault in part["faults"]}
    return {
        "inputs": sum(part["inputs"] for part in done),
        "read": sum(part["read"] for part in done),
        "faults": [faults[place] for place in sorted(faults)],
        "worst_seconds": round(max(part["worst_seconds"] for part in done), 3),
        "peak_growth_mib": round(max(part["peak_growth_mib"] for part in done), 1),
    }


def fuzz_part(name: str, seed: str, inputs: int) -> dict[str, Any]:
    """Feed ``inputs`` changed files to one reader; return the counts, the worst case and the faults by place."""
    _limit_memory()
    target, tally, faults = TARGETS[name], Tally(), dict[str, dict[str, str]]()
    numbers = random.Random(seed)
    for _ in range(inputs):
        content = drawn(target, numbers)
        try:
            call(target, content, tally)
        except Fault as fault:
            place = _place(fault)
            if place not in faults:
                faults[place] = {"fault": str(fault), "place": place, "input": _store(target, content)}
    StandingPool.end()
    return {
        "inputs": tally.inputs,
        "read": tally.read,
        "faults": list(faults.values()),
        "worst_seconds": tally.worst_seconds,
        "peak_growth_mib": tally.peak_growth_mib,
    }


def _store(target: Target, content: bytes) -> str:
    path = SEEDS / target.name / hashlib.sha256(content).hexdigest()[:12]
    write_bytes(path, content)
    return str(path.relative_to(SEEDS.parents[2]))


def _place(fault: Fault) -> str:
    """Name the project's innermost line that a fault passed through: faults of one line count once."""
    root, place = SEEDS.parents[2], str(fault)[:60]
    trace = fault.__cause__.__traceback__ if fault.__cause__ else None
    while trace is not None:
        path = Path(trace.tb_frame.f_code.co_filename)
        if path.is_relative_to(root):
            place = f"{type(fault.__cause__).__name__} at {path.relative_to(root)}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place


def _limit_memory() -> None:
    mapped = Path("/proc/self/statm")
    if mapped.exists():
        used = int(mapped.read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, resource.getrlimit(resource.RLIMIT_AS)[1]))


@cache  # before the first result is written, which changes the tree
def _version() -> str:
    described = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return described.stdout.strip() or "unknown"


if __name__ == "__main__":
    main()
