"""Child commands: a command line in, its exit code and messages out; all of them end with this command."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Lock

from haptid.support.interrupts import TERMINATED

GRACE_S = 10.0
"""Time [s] after SIGTERM in which a command has to end, its workers with it, before it is killed."""


class Running:
    """Set of child commands that several threads start and one call ends."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._processes: set[subprocess.Popen[str]] = set()
        self._ended = False

    def run(
        self, command: Sequence[str], *, cwd: Path, env: Mapping[str, str] | None = None, limit: float | None = None
    ) -> tuple[int, str]:
        """Run a command to its end.

        Parameters
        ----------
        command
            Program and arguments.
        cwd
            Working directory.
        env
            Environment; this process's where None.
        limit
            Longest duration [s]; none where None.

        Returns
        -------
        code : int
            Exit code; `TERMINATED` without a start where `end` was called before.
        said : str
            Text that the command wrote to stderr.

        Raises
        ------
        TimeoutExpired
            After ``limit`` seconds; the command is ended.
        """
        with self._lock:
            if self._ended:  # a thread that comes late must not start what nobody would end
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
        """Send SIGTERM to all running commands, and refuse to start further ones."""
        with self._lock:
            self._ended = True
            for process in self._processes:
                process.terminate()


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.communicate(timeout=GRACE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
