"""``--json``: the result alone on standard output, from real processes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from haptid.support.installing.environment import ROOT


def run_haptid(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "haptid", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_check_prints_facts_in_si_units():
    done = run_haptid("check", "--json")
    assert done.returncode == 0, done.stderr
    runs = json.loads(done.stdout)["runs"]
    first = runs[0]
    assert (first["file"], first["joint"], first["rate_Hz"]) == ("joint0_0_w1.csv.gz", 0, pytest.approx(200))
    assert first["noise_rad"] == pytest.approx(2e-4)
    assert "joint0_0_w1.csv.gz" in done.stderr


def test_identify_and_export_print_what_they_wrote(tmp_path: Path):
    done = run_haptid(
        "identify", "--joints", "4", "--fmu", "none", "--workers", "1", "--no-export", "--out", tmp_path, "--json"
    )
    assert done.returncode == 0, done.stderr
    written = tmp_path / "identification.json"
    assert json.loads(done.stdout) == json.loads(written.read_text(encoding="utf-8"))
    assert json.loads(done.stdout)["command"].startswith("haptid identify --joints 4 ")
    assert "written below" in done.stderr

    fmu = tmp_path / "joint4.fmu"
    done = run_haptid("export", "--from", written, "--joints", "4", "--out", fmu, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["fmu"], told["kind"], told["bytes"]) == (str(fmu), "python", fmu.stat().st_size)


def test_plan_prints_the_plan(tmp_path: Path):
    done = run_haptid("plan", "--no-design", "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == json.loads((tmp_path / "locking_plan.json").read_text(encoding="utf-8"))


@pytest.mark.long
def test_a_stage_of_the_search_prints_its_finding(tmp_path: Path):
    done = run_haptid("missing", "--joint", "4", "--stage", "gap", "--out", tmp_path, "--json", "--quiet")
    assert done.returncode == 0, done.stderr
    written = tmp_path / "discrepancy" / "joint4_gap.json"
    assert json.loads(done.stdout) == json.loads(written.read_text(encoding="utf-8"))


def test_an_error_leaves_standard_output_empty(tmp_path: Path):
    done = run_haptid("identify", tmp_path / "nothing", "--out", tmp_path / "out", "--json")
    assert (done.returncode, done.stdout) == (2, "")
    (error,) = done.stderr.splitlines()
    assert error.startswith("error: ")
