"""Commands that run beside this one, and end with it."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Lock

from haptid.support.command import TERMINATED

GRACE = 10.0
"""Time [s] that a command has to end by itself, its workers with it, before it is killed."""


class Running:
    """Commands under way, from several threads."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._processes: set[subprocess.Popen[str]] = set()
        self._ended = False

    def run(
        self, command: Sequence[str], *, cwd: Path, env: Mapping[str, str] | None = None, limit: float | None = None
    ) -> tuple[int, str]:
        """Run a command to its end; return its exit code and what it said on stderr.

        Raises
        ------
        TimeoutExpired
            After ``limit`` seconds; the command is ended.
        """
        with self._lock:
            if self._ended:
                return TERMINATED, ""
            process = subprocess.Popen(
                command, cwd=cwd, env=env, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
            )
            self._processes.add(process)
        try:
            _, said = process.communicate(timeout=limit)
        finally:
            _end(process)
            with self._lock:
                self._processes.remove(process)
        return process.returncode, said

    def end(self) -> None:
        """Ask what is under way to end, and begin no more."""
        with self._lock:
            self._ended = True
            for process in self._processes:
                process.terminate()


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.communicate(timeout=GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
