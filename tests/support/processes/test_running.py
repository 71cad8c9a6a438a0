"""Commands that run beside another one end with it."""

import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from haptid.support.interrupts import TERMINATED
from haptid.support.processes.running import Running

HERE = Path(__file__).parent
SLEEPS = [sys.executable, "-c", "import time; time.sleep(60)"]


def test_the_exit_code_and_what_was_said_come_back() -> None:
    said = [sys.executable, "-c", "import sys; print('no'); sys.exit('the cause')"]
    assert Running().run(said, cwd=HERE) == (1, "the cause\n")


def test_what_takes_too_long_is_ended() -> None:
    with pytest.raises(subprocess.TimeoutExpired):
        Running().run(SLEEPS, cwd=HERE, limit=0.2)


def test_all_are_ended_together_and_no_more_begun() -> None:
    running, began = Running(), time.monotonic()
    with ThreadPoolExecutor(2) as pool:
        each = [pool.submit(running.run, SLEEPS, cwd=HERE) for _ in range(2)]
        while len(running._processes) != 2:
            time.sleep(0.01)
        running.end()
        assert [one.result()[0] for one in each] == [-signal.SIGTERM] * 2
    assert running.run(SLEEPS, cwd=HERE) == (TERMINATED, "")
    assert time.monotonic() - began < 30.0
