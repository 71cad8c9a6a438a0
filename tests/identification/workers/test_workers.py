"""Processes that fits run in."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from haptid.support.installing.environment import ROOT

PARENT = """
import os, time
from haptid.identification.workers.workers import Processes

def told(path):
    with open(path, "w") as f:
        f.write(str(os.getpid()))
    time.sleep(600)

if __name__ == "__main__":
    with Processes(1) as pool:
        pool.submit(told, {path!r}).result()
"""


def _alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and is not yet reaped does not."""
    stat = Path(f"/proc/{pid}/stat")
    try:
        os.kill(pid, 0)
        return not (stat.exists() and stat.read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z")
    except (ProcessLookupError, FileNotFoundError):
        return False


def _until(condition, seconds: float = 60.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end and not condition():
        time.sleep(0.05)
    return condition()


def test_workers_end_with_a_parent_that_was_killed(tmp_path: Path):
    told, script = tmp_path / "pid", tmp_path / "parent.py"
    script.write_text(PARENT.format(path=str(told)), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    parent = subprocess.Popen([sys.executable, str(script)], env=environment)
    try:
        assert _until(lambda: told.exists() and told.read_text(encoding="utf-8") != "")
        worker = int(told.read_text(encoding="utf-8"))
        assert _alive(worker)
    finally:
        os.kill(parent.pid, signal.SIGKILL)
        parent.wait()
    assert _until(lambda: not _alive(worker))
