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
    "haptid check, first word on a terminal": ("check",),
    "haptid identify, first word on a terminal": ("identify", "--out", "{folder}/out"),
    "haptid posterior, first word on a terminal": ("posterior", "--out", "{folder}/out"),
    "haptid missing, first word on a terminal": ("missing", "--out", "{folder}/out"),
}
"""Arguments by what is timed until its first byte on a pseudo-terminal."""


def seconds_to_first_byte(arguments: tuple[str, ...]) -> float:
    """Start ``haptid`` and return the time until it writes anything [s]; then it is ended."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "haptid", *(one.format(folder=folder) for one in arguments)]
        begun = time.perf_counter()
        host, terminal = os.openpty()
        running = subprocess.Popen(command, stdout=terminal, stderr=terminal, cwd=Path.cwd())
        os.read(host, 1)
        passed = time.perf_counter() - begun
        running.kill()
        running.wait()
        os.close(host)
        os.close(terminal)
    return passed


def waiting_times() -> dict[str, float]:
    """Return the shortest time until the first byte by what was started [s]."""
    return {name: min(seconds_to_first_byte(one) for _ in range(REPEATS)) for name, one in FIRST_LINES.items()}
