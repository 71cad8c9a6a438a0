"""The command: files, exit codes, interruption, real data."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import haptid.identification.job.identify as flow
from haptid.identification.run import main
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.identification.bench_joint import TRUE
from tests.real_data import DATA
from tests.report.reading import OWN_SCRIPTS

ROOT = Path(__file__).parents[2]
FAST = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton")
COSINES = (
    Cosine(amplitude=0.005, frequency=1.13, duration=6.0),
    Cosine(amplitude=0.004, frequency=2.4, duration=6.0),
    Cosine(amplitude=0.0045, frequency=1.75, duration=6.0, use="validate"),
)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    make_joint_campaign(folder, 4, {**TRUE, "Kp": 1.0}, COSINES, sensor=Sensor(noise=2e-4, resolution=1.5e-4), seed=4)
    return folder


def run(*arguments: object):
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def identified(campaign, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    done = run(campaign, "--out", out, "--no-export", *FAST)
    assert done.exit_code == 0, done.output
    return out, json.loads((out / "identification.json").read_text()), done


def test_single_joint_needs_no_numbers(identified):
    _, data, _ = identified
    (one,) = data["configurations"]
    assert one["outcome"] == "converged"
    unseen = [r for r in one["runs"] if r["use"] == "validate"]
    assert unseen[0]["rmse_over_noise"] < 1.06
    for id in ("sigma0", "sigma2", "Fs", "Fc", "vs", "inertia"):
        found = one["parameters"][id]
        assert abs(found["value"] - TRUE[id]) < 4 * found["std"], id


def test_json_has_the_fields_that_stay_fixed(identified):
    _, data, _ = identified
    head = {"schema", "device", "campaign", "measured", "seed", "software", "locking_order", "configurations"}
    assert head | {"links", "verification"} <= set(data)
    assert data["schema"] == "identification/1"
    assert data["measured"] is False
    assert data["locking_order"] == [[4]]
    (one,) = data["configurations"]
    assert {
        "free_joints",
        "parameters",
        "runs",
        "noise_rad",
        "cost",
        "outcome",
        "starts",
        "simulations",
        "wall_s",
    } <= set(one)
    assert all({"value", "std", "unit", "status"} <= set(p) for p in one["parameters"].values())
    assert all({"file", "use", "rmse_rad", "rmse_over_noise", "nrmse"} <= set(r) for r in one["runs"])


def test_report_is_one_file_with_the_synthetic_label(identified):
    out, _, done = identified
    page = (out / "report.html").read_text()
    assert "SYNTHETIC DATA" in page
    # The library's script begins with its address in a comment.
    assert "http" not in page.replace(OWN_SCRIPTS[0], "").replace("http-equiv", "")
    assert "data:image/svg+xml;base64" in page
    assert "joint 4" in done.stdout


def test_interrupted_run_goes_on_where_it_stopped(identified, campaign, tmp_path, monkeypatch):
    _, whole, _ = identified
    sought = []
    real = flow.write_json

    def stop_after_first(path, data):
        real(path, data)
        raise KeyboardInterrupt

    monkeypatch.setattr(flow, "write_json", stop_after_first)
    stopped = run(campaign, "--out", tmp_path, "--no-export", *FAST)
    assert stopped.exit_code == 130
    (told,) = [line for line in stopped.stderr.splitlines() if line.startswith("interrupted")]
    assert told.startswith("interrupted: 1 of 1 configurations are kept; the same command goes on with the next one: ")
    monkeypatch.setattr(flow, "write_json", real)
    kept = json.loads((tmp_path / "identification.json").read_text())
    assert kept["complete"] is False
    assert len(kept["configurations"]) == 1
    monkeypatch.setattr("haptid.identification.sequence.sequence.fit_runs", lambda *a, **_: sought.append(a))
    assert run(campaign, "--out", tmp_path, "--no-export", *FAST).exit_code == 0
    again = json.loads((tmp_path / "identification.json").read_text())
    assert sought == []
    assert again["complete"] is True
    assert again["configurations"][0]["parameters"] == whole["configurations"][0]["parameters"]


def state_of(pid: str, field: str) -> str:
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return ""
    return next(line.split()[1] for line in lines if line.startswith(field))


def deaf(pid: str) -> bool:
    """Whether a process leaves Ctrl-C to its parent."""
    masks = [int(state_of(pid, field) or "0", 16) for field in ("SigBlk", "SigIgn")]
    return any(mask >> (signal.SIGINT - 1) & 1 for mask in masks)


def runs_still(pid: str) -> bool:
    return state_of(pid, "State") not in {"", "Z"}


def with_workers(command: list[str]) -> tuple[subprocess.Popen[str], list[str]]:
    """Start a run and wait for two workers, still importing, and the tracker.

    A shell that puts the tests into the background has them, and all that they start, ignore Ctrl-C.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, cwd=ROOT
        )
    finally:
        signal.signal(signal.SIGINT, before)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    ours: list[str] = []
    while process.poll() is None and len(ours) < 3:
        time.sleep(0.02)
        with contextlib.suppress(OSError):
            ours = children.read_text().split()
    return process, ours


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="finds the workers in /proc")
def test_ctrl_c_ends_workers_in_one_line(campaign, tmp_path):
    command = [sys.executable, "-m", "identification.run", str(campaign), "--quiet"]
    command += ["--workers", "2", "--fmu", "none", "--starts", "512", "--no-export", "--out", str(tmp_path)]
    process, ours = with_workers(command)
    assert all(map(deaf, ours))
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.strip().splitlines() == ["interrupted: nothing was finished yet"]
    until = time.monotonic() + 20.0
    while any(map(runs_still, ours)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(runs_still, ours))


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("nowhere",), "nowhere"),
        (("--joints", "9"), "--joints"),
        (("--joints", "x"), "--joints"),
        (("--scheduler", "tcp://127.0.0.1:1", "--joints", "4"), "--scheduler"),
    ],
)
def test_bad_input_writes_nothing(arguments, told, tmp_path):
    out = tmp_path / "out"
    done = run(*arguments, "--out", out, *FAST)
    assert done.exit_code == 2, done.output
    assert told in done.stderr
    assert done.stderr.count("\n") == 1
    assert not out.exists()


def test_out_must_not_be_a_file(campaign, tmp_path):
    (tmp_path / "out").write_text("")
    assert run(campaign, "--out", tmp_path / "out", *FAST).exit_code == 2


@pytest.mark.long
@pytest.mark.real("dvrk_mtm_joint4")
def test_real_tendon_joint_does_not_claim_a_good_fit(tmp_path):
    done = run(DATA / "dvrk_mtm_joint4", "--out", tmp_path, "--no-export", *FAST)
    assert done.exit_code == 0, done.output
    (one,) = json.loads((tmp_path / "identification.json").read_text())["configurations"]
    assert one["outcome"] != "converged"
    assert all(np.isfinite(p["value"]) for p in one["parameters"].values())
    table = pd.read_csv(DATA / "dvrk_mtm_joint4" / "joint4_sweep.csv")
    up, down = (table[np.sign(table.velocity_4_rad_s) == s].torque_4_Nm.mean() for s in (1, -1))
    friction = one["parameters"]["Fc"]["value"] + 0.4 * one["parameters"]["sigma2"]["value"]  # at the sweep's 0.4 rad/s
    assert 0.5 < friction / ((up - down) / 2) < 2.0
