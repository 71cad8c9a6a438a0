"""The door ``haptid``: help without imports, unknown commands in one line."""

from __future__ import annotations

import subprocess
import sys

import pytest
from click.testing import CliRunner

from haptid.command_line import COMMANDS, main
from haptid.support.installing.environment import ROOT


def test_help_imports_no_package():
    script = "\n".join((
        "import runpy, sys",
        "try:",
        "    runpy.run_module('haptid', run_name='__main__')",
        "finally:",
        "    print([m for m in sys.modules if m.startswith('haptid.') or m == 'numpy'])",
    ))  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-c", script, "--help"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "['haptid.command_line']" in done.stdout
    assert all(name in done.stdout for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_there(name: str):
    done = CliRunner().invoke(main, [name, "--help"])
    assert done.exit_code == 0
    assert "Usage: " in done.output


def test_an_unknown_command_is_one_line_with_what_it_may_have_meant():
    done = CliRunner().invoke(main, ["identfy"])
    assert done.exit_code == 2
    assert done.output.count("\n") == 1
    assert done.output.endswith("got 'identfy'; did you mean identify?\n")
