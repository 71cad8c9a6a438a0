"""How long a user waits before anything is computed, and what a report weighs."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

REPEATS = 5
"""Starts of a command, of which the fastest counts: the others waited for the disk or for other programs."""
FIRST_LINES: Mapping[str, tuple[str, ...]] = {
    "haptid --version": ("--version",),
    "haptid --help": ("--help",),
    "haptid identify --help": ("identify", "--help"),
    "haptid check, first word in a pipe": ("check",),
    "haptid identify, first word in a pipe": ("identify", "--out", "{folder}/out"),
    "haptid posterior, first word in a pipe": ("posterior", "--out", "{folder}/out"),
    "haptid missing, first word in a pipe": ("missing", "--out", "{folder}/out"),
}
"""Arguments by what is timed until its first byte."""


def seconds_to_first_byte(arguments: tuple[str, ...]) -> float:
    """Start ``haptid`` and return the time until it writes anything [s]; then it is ended."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "haptid", *(one.format(folder=folder) for one in arguments)]
        begun = time.perf_counter()
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=Path.cwd())
        assert running.stdout is not None
        os.read(running.stdout.fileno(), 1)
        passed = time.perf_counter() - begun
        running.kill()
        running.stdout.close()
        running.wait()
    return passed


def waiting_times() -> dict[str, float]:
    """Return the shortest time until the first byte by what was started [s]."""
    return {name: min(seconds_to_first_byte(one) for _ in range(REPEATS)) for name, one in FIRST_LINES.items()}
