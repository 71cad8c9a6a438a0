"""Tests marked ``alone`` run in a process of their own: a host that embeds Python may leave the interpreter damaged."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

INSIDE = "HAPTID_TEST_ALONE"


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    if pyfuncitem.get_closest_marker("alone") is None or INSIDE in os.environ:
        return None
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_")} | {INSIDE: "1"}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", pyfuncitem.nodeid]
    done = subprocess.run(
        command, cwd=pyfuncitem.config.rootpath, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        pytest.fail(f"exit code {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-1000:]}", pytrace=False)
    return True
