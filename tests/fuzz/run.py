"""``python -m tests.fuzz.run`` (``make fuzz``): feed changed files to the readers, store what fails and the result."""

from __future__ import annotations

import hashlib
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
from hypothesis import HealthCheck, Phase, given, seed, settings
from tqdm import tqdm

from support.command import exit_codes, progress
from support.files import write_bytes, write_json
from tests.fuzz.harness import Fault, Tally, Target, call, inputs_of
from tests.fuzz.targets import TARGETS

BATCH = 2000
SEEDS = Path(__file__).parent / "seeds"
ROOM = 4 << 30
"""Address space beside what is mapped at the start [bytes]: a reader that runs away fails instead of the machine."""


@click.command()
@click.option("--inputs", type=click.IntRange(min=1), default=100_000, show_default=True, help="Inputs a reader.")
@click.option("--target", "names", multiple=True, type=click.Choice(list(TARGETS)), help="Only this; may be repeated.")
@click.option("--seed", "first", type=int, default=0, show_default=True, help="Same seed, same inputs.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), default=Path("docs/results/fuzzing.json"),
              show_default=True, help="Where the result goes.")  # fmt: skip
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
def main(inputs: int, names: tuple[str, ...], first: int, out: Path, quiet: bool) -> None:
    """Feed changed files to every reader; exit 1 where one does anything but read or refuse in one line.

    Inputs that fail are stored below tests/fuzz/seeds, one for each place that fails; the test suite replays them.
    """
    _limit_memory()
    readers = {name: _fuzz(TARGETS[name], inputs, first, quiet) for name in names or TARGETS}
    stored = {
        "command": f"python -m tests.fuzz.run {' '.join(sys.argv[1:])}".strip(),
        "date": datetime.now(UTC).date().isoformat(),
        "version": _version(),
        "python": sys.version.split()[0],
        "readers": readers,
    }
    write_json(out, stored)
    for name, result in readers.items():
        counts = f"{result['inputs']} inputs, {result['read']} read, {len(result['faults'])} faults"
        click.echo(f"{name}: {counts}, worst {result['worst_seconds']} s, {result['peak_growth_mib']} MiB")
    if any(result["faults"] for result in readers.values()):
        sys.exit(1)


def _fuzz(target: Target, inputs: int, first: int, quiet: bool) -> dict[str, Any]:
    tally, faults, begun = Tally(), dict[str, dict[str, str]](), time.monotonic()
    with progress(total=inputs, title=target.name, quiet=quiet) as bar:
        number = first
        while tally.inputs < inputs:
            # batches of their own seeds: Hypothesis remembers all inputs of one run
            _batch(target, number, min(BATCH, inputs - tally.inputs), _reader(target, tally, faults, bar))
            number += 1
    return {
        "inputs": tally.inputs,
        "read": tally.read,
        "faults": list(faults.values()),
        "worst_seconds": round(tally.worst_seconds, 3),
        "peak_growth_mib": round(tally.peak_growth_mib, 1),
        "wall_s": round(time.monotonic() - begun, 1),
    }


def _batch(target: Target, number: int, inputs: int, read: Callable[[bytes], None]) -> None:
    options = settings(
        max_examples=inputs,
        database=None,
        deadline=None,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    seed(number)(options(given(inputs_of(target))(read)))()


def _reader(target: Target, tally: Tally, faults: dict[str, dict[str, str]], bar: tqdm[Any]) -> Callable[[bytes], None]:
    def read(content: bytes) -> None:
        bar.update()
        try:
            call(target, content, tally)
        except Fault as fault:
            place = _place(fault)
            if place not in faults:
                faults[place] = {"fault": str(fault), "place": place, "input": _store(target, content)}

    return read


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


def _version() -> str:
    described = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return described.stdout.strip() or "unknown"


if __name__ == "__main__":
    main()
