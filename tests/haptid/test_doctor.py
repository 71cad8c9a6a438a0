"""``haptid doctor``: what it finds in this environment, and in broken ones."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid import doctor
from haptid.command_line import main
from haptid.support.installing.environment import ROOT, Requirement


def test_a_sound_installation_passes_every_check():
    command = [sys.executable, "-m", "haptid", "doctor", "--json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    names = [check["name"] for check in told["checks"]]
    assert names == ["Python", "packages", "compiler", "cores", "cache", "disk", *doctor.EXTRAS, "kernel", "FMU"]
    assert told["ok"]
    assert not list((Path(doctor.cache_folder("doctor"))).iterdir())


def test_problems_are_told_with_their_remedies(monkeypatch: pytest.MonkeyPatch):
    def lacking(extra: str | None = None) -> tuple[Requirement, ...]:
        return (Requirement("numpy>=9", "numpy", ()),) if extra in (None, "posterior") else ()

    monkeypatch.setattr(doctor, "missing", lacking)
    monkeypatch.setattr(doctor, "LEAST_FREE_BYTES", 10**30)
    done = CliRunner().invoke(main, ["doctor", "--json"])
    assert done.exit_code == 1
    checks = {check["name"]: check for check in json.loads(done.stdout)["checks"]}
    assert checks["packages"]["found"] == "lacks numpy>=9"
    assert checks["disk"]["status"] == "PROBLEM"
    assert checks["posterior"]["status"] == "absent"
    assert "kernel" not in checks
    assert "2 of 13 checks found a problem: packages, disk" in done.stderr


def test_a_check_that_breaks_is_a_finding(monkeypatch: pytest.MonkeyPatch):
    def broken() -> str:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(doctor, "_kernel", broken)
    monkeypatch.setattr(doctor, "_fmu", lambda: "runs")
    done = CliRunner().invoke(main, ["doctor"])
    assert done.exit_code == 1
    assert "PROBLEM  kernel     OSError: [Errno 5] Input/output error: repair it by" in done.stdout
