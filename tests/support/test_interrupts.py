"""Ctrl-C that Python or an imported module drops is heard all the same."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from haptid.support.installing.environment import ROOT

DROPPED = {
    "callback of a weak reference": """
        import os, signal, weakref
        class Lock: pass
        lock = Lock()
        watch = weakref.ref(lock, lambda _: os.kill(os.getpid(), signal.{signal}))
        del lock
        """,
    "caught by what is imported": """
        import os, signal
        try:
            os.kill(os.getpid(), signal.{signal})
            import json
        except BaseException:
            pass
        """,
    "an error in its place": """
        import os, signal
        try:
            os.kill(os.getpid(), signal.{signal})
            import json
        except BaseException:
            raise ImportError("initialization failed")
        """,
}
COMMAND = """
import signal
from haptid.support.command import exit_codes
from haptid.support.declaring.declaration import call

def main():
    call("work", "work")

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job inherits that it is ignored
    exit_codes(main)()
"""


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
@pytest.mark.parametrize("module", DROPPED.values(), ids=DROPPED)
def test_an_interrupt_dropped_while_the_work_is_imported_ends_the_command(
    module: str, name: str, code: int, tmp_path: Path
):
    body = textwrap.dedent(module.format(signal=name))
    (tmp_path / "work.py").write_text(body + "def work(): print(1)", encoding="utf-8")
    (tmp_path / "command.py").write_text(COMMAND, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "command.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.stdout == ""
    assert done.returncode == code
    assert done.stderr.splitlines() == ["interrupted: nothing was finished yet"]


def test_a_command_that_ignores_interrupts_is_not_ended_before_it_begins():
    program = "import os, signal\nfrom haptid.support.interrupts import end_at_interrupt\n"
    program += "signal.signal(signal.SIGINT, signal.{})\nend_at_interrupt()\nos.kill(os.getpid(), signal.SIGINT)\n"

    def ended(handler: str) -> int:
        command = [sys.executable, "-c", program.format(handler)]
        return subprocess.run(command, cwd=ROOT, capture_output=True, timeout=60, check=False).returncode

    assert ended("SIG_IGN") == 0
    assert ended("default_int_handler") == 130
