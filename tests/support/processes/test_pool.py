"""Ctrl-C while workers start."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from haptid.support.installing.environment import ROOT
from haptid.support.processes.pool import interrupts_held_back

BEGUN = """
import os, signal, threading, time
from multiprocessing import util
from haptid.support.command import exit_codes
from haptid.support.processes.pool import Pool

@exit_codes
def main():
    threading.Thread(target=threading.Event().wait, daemon=True).start()  # takes signals, as a progress bar's does
    with Pool(2) as pool:
        pool.submit(abs, 1)
        start = util.spawnv_passfds
        def interrupted(*arguments):
            child = start(*arguments)
            os.kill(os.getpid(), signal.{signal})
            time.sleep(0.2)
            return child
        util.spawnv_passfds = interrupted
        pool.submit(abs, 2)
    raise SystemExit("not interrupted")

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    main()
"""


@pytest.fixture
def listener() -> Iterator[None]:
    """Run another thread that takes signals, as BLAS's or a progress bar's does."""
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    yield
    done.set()
    thread.join()


def _interrupted(reached: list[int]) -> None:
    with interrupts_held_back():
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.2)  # the other thread may take the signal at its leisure
        reached.extend(range(1000))


@pytest.mark.usefixtures("listener")
def test_an_interrupt_waits_for_the_end_of_what_it_must_not_cut():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    reached = []
    try:
        with pytest.raises(KeyboardInterrupt):
            _interrupted(reached)
        assert len(reached) == 1000
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_what_ignores_interrupts_goes_on_ignoring_them():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_held_back():
            os.kill(os.getpid(), signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_an_interrupt_between_a_workers_start_and_what_it_is_told(name: str, code: int, tmp_path: Path):
    script = tmp_path / "begun.py"
    script.write_text(BEGUN.format(signal=name), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stderr.splitlines() == ["interrupted: nothing was finished yet"]
    assert done.returncode == code
