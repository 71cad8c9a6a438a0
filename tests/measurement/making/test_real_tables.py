"""``haptid init`` on tables as loggers write them, by real processes and by replies."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.measurement import new
from haptid.measurement.format.reading import read_campaign
from haptid.model.device.reader import load_device
from haptid.support.installing.environment import ROOT

ARM = ROOT / "model" / "device" / "built_in" / "arm6.urdf"
ROWS = np.arange(400)


def write_pendulum(folder: Path, names: tuple[str, ...] = ("a.csv", "val_1.csv", "val_2.csv")) -> None:
    """Write tables in milliseconds, degrees and N mm."""
    folder.mkdir()
    t = ROWS * 2.0
    for k, name in enumerate(names, start=1):
        columns = {"time_ms": t, "torque (Nmm)": k * np.cos(0.01 * t), "Angle (deg)": 5 * k * np.sin(0.01 * t)}
        pd.DataFrame(columns).to_csv(folder / name, index=False)


def write_arm(folder: Path) -> None:
    """Write a logger's table of two joints, of which the second is locked and read with noise."""
    folder.mkdir()
    t, rng = ROWS * 0.005, np.random.default_rng(0)
    frame = pd.DataFrame({
        "time_s": t,
        "torque_0_Nm": np.cos(3 * t), "position_0_deg": 20 * np.sin(3 * t) + 0.01 * rng.standard_normal(t.size),
        "torque_1_Nm": 0.0, "position_1_deg": 30 + 0.01 * rng.standard_normal(t.size),
    })  # fmt: skip
    frame.to_csv(folder / "one.csv", index=False)


def run_init(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "haptid", "init", str(folder), *map(str, arguments)]
    place = {"cwd": ROOT, "stdin": subprocess.DEVNULL, "capture_output": True, "text": True}
    return subprocess.run(command, check=False, **place)


def ask_init(monkeypatch: pytest.MonkeyPatch, replies: str, *arguments: object):
    monkeypatch.setattr(new, "_can_ask", lambda: True)
    return CliRunner().invoke(new.main, [str(part) for part in arguments], input=replies)


def test_one_command_makes_a_campaign_from_degrees_and_milliseconds(tmp_path: Path):
    write_pendulum(tmp_path / "tables")
    out = tmp_path / "made"
    done = run_init(tmp_path / "tables", "--out", out, "--measured", "--validate", "val_*.csv", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["understood"]["Angle (deg)"]["name"] == "position_0_rad"
    assert [run["use"] for run in told["runs"]] == ["fit", "validate", "validate"]
    run = read_campaign(out).runs[0]
    np.testing.assert_allclose(run.y[:, 0], np.deg2rad(5 * np.sin(0.02 * ROWS)), rtol=1e-14)
    np.testing.assert_allclose(run.u[:, 0], 1e-3 * np.cos(0.02 * ROWS), rtol=1e-14)
    np.testing.assert_allclose(run.t, 2e-3 * ROWS, rtol=1e-14)
    assert "torque (Nmm) is torque_0_Nm, × 0.001" in done.stderr
    assert "a.csv: fit, 400 rows, 0.798 s at 500 Hz; joint 0 moves by 0.175 rad" in done.stderr


def test_counts_are_converted_by_the_stated_step(tmp_path: Path):
    folder, counts = tmp_path / "tables", np.round(200 * np.sin(0.02 * ROWS)).astype(int)
    folder.mkdir()
    columns = {"time_s": 0.002 * ROWS, "torque_0_Nm": np.cos(0.02 * ROWS), "encoder counts": counts}
    pd.DataFrame(columns).to_csv(folder / "a.csv", index=False)
    refused = run_init(folder, "--out", tmp_path / "made", "--measured")
    assert refused.returncode == 2
    assert "expected the angle of one count [rad], got none; state it by --resolution" in refused.stderr
    assert run_init(folder, "--out", tmp_path / "made", "--measured", "--resolution", "0.0015").returncode == 0
    np.testing.assert_allclose(read_campaign(tmp_path / "made").runs[0].y[:, 0], 0.0015 * counts)


def test_a_locked_joint_is_not_free_and_its_posture_is_kept(tmp_path: Path):
    write_arm(tmp_path / "tables")
    (tmp_path / "tables" / "arm.urdf").write_bytes(ARM.read_bytes())
    out = tmp_path / "made"
    done = run_init(tmp_path / "tables", "--out", out, "--measured", "--device", "arm.urdf")
    assert done.returncode == 0, done.stderr
    made = tomllib.loads((out / "campaign.toml").read_text(encoding="utf-8"))
    assert made["campaign"]["device"] == "arm.urdf"
    assert len(load_device(str(out / "arm.urdf")).joints) == 6
    posture = made["runs"][0]["locked_positions_rad"]
    assert made["runs"][0]["free_joints"] == [0]
    assert posture == [0.0, pytest.approx(np.deg2rad(30), abs=1e-4), 0.0, 0.0, 0.0, 0.0]
    assert "; held: 1\n" in done.stdout


def test_free_overrules_what_moves(tmp_path: Path):
    write_arm(tmp_path / "tables")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured", "--free", "0,1", "--device", ARM)
    assert done.returncode == 0, done.stderr
    assert read_campaign(tmp_path / "made").runs[0].free_joints == (0, 1)


def test_a_device_that_is_nowhere_is_refused_by_its_own_name(tmp_path: Path):
    write_pendulum(tmp_path / "tables")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured", "--device", "arm.urdf")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert f"got no arm.urdf here and none in {tmp_path / 'tables'}" in done.stderr
    assert not (tmp_path / "made").exists()


def test_a_wrong_reply_is_asked_again_and_the_others_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write_pendulum(tmp_path / "tables")
    replies = "Mine\nrobot\nsingle_joint\ny\nthree.csv\nval_*.csv\nmuch\n2e-4\n\n\n"
    done = ask_init(monkeypatch, replies, tmp_path / "tables", "--out", tmp_path / "made")
    assert done.exit_code == 0, done.output
    campaign = read_campaign(tmp_path / "made")
    assert (campaign.title, campaign.device, campaign.noise_given) == ("Mine", "single_joint", True)
    assert [run.use for run in campaign.runs] == ["fit", "validate", "validate"]
    assert done.output.count("Error: ") == 3


def test_counts_and_unnamed_columns_are_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = tmp_path / "tables"
    folder.mkdir()
    columns = {"ms": 2.0 * ROWS, "tau": np.cos(0.02 * ROWS), "encoder counts": np.round(200 * np.sin(0.02 * ROWS))}
    pd.DataFrame(columns).to_csv(folder / "a.csv", index=False)
    replies = "Mine\n\ny\n2*0.00075\ntime_s*0.001\ntorque\ntorque_0_Nm\n\n\n"
    done = ask_init(monkeypatch, replies, folder, "--out", tmp_path / "made")
    assert done.exit_code == 0, done.output
    run = read_campaign(tmp_path / "made").runs[0]
    np.testing.assert_allclose(run.y[:, 0], 0.0015 * columns["encoder counts"])
    np.testing.assert_allclose(run.t, 0.002 * ROWS)


@pytest.mark.parametrize("header", ["time_s,torque_{n}_Nm,position_{n}_rad", "time_s,tau{n} Nm,angle deg"])
def test_a_number_of_thousands_of_digits_is_no_joint(header: str, tmp_path: Path):
    rows = "".join(f"{0.1 * k:.1f},{k % 3},{k % 4}\n" for k in range(20))
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "a.csv").write_text(f"{header.format(n='9' * 5000)}\n{rows}", encoding="utf-8")
    done = CliRunner().invoke(new.main, [str(tmp_path / "tables"), "--out", str(tmp_path / "out"), "--measured"])
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert len(done.stderr) <= 310
    assert not (tmp_path / "out").exists()


def test_a_file_in_place_of_its_folder_is_told(tmp_path: Path):
    write_pendulum(tmp_path / "tables")
    told = run_init(tmp_path / "tables" / "a.csv", "--out", tmp_path / "made", "--yes")
    assert told.returncode == 2
    assert told.stderr.startswith(
        f"error: {tmp_path / 'tables' / 'a.csv'}: expected a folder of tables, got a file; name"
    )
    assert told.stderr.rstrip().endswith(f"haptid init {tmp_path / 'tables'}")


def test_dates_make_a_campaign(tmp_path: Path):
    write_pendulum(tmp_path / "tables", ("a.csv",))
    frame = pd.read_csv(tmp_path / "tables" / "a.csv")
    frame["time_ms"] = (pd.Timestamp("2026-03-12T10:00:00") + pd.to_timedelta(frame["time_ms"], unit="ms")).astype(str)
    frame.rename(columns={"time_ms": "Timestamp"}).to_csv(tmp_path / "tables" / "a.csv", index=False)
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--yes")
    assert done.returncode == 0, done.stderr
    assert "a.csv has dates in 'Timestamp', read as seconds from the first row" in done.stdout
    np.testing.assert_allclose(read_campaign(tmp_path / "made").runs[0].t, 2e-3 * ROWS, atol=1e-9)


def test_init_says_what_check_will_say(tmp_path: Path):
    write_pendulum(tmp_path / "tables", ("a.csv", "b.csv"))
    for name in ("a.csv", "b.csv"):
        path = tmp_path / "tables" / name
        path.write_text(path.read_text().replace("time_ms", "time_s", 1))
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--yes", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["refused"].startswith(
        f"{tmp_path / 'made' / 'a.csv'}, time_s: expected time in seconds, with rows 0.5 s"
    )
    assert f"to mend before a fit: {told['refused']}" in done.stderr
    assert "next: " not in done.stderr


def test_init_ends_with_the_remarks(tmp_path: Path):
    write_pendulum(tmp_path / "tables", ("a.csv", "b.csv"))
    shutil.copy(tmp_path / "tables" / "a.csv", tmp_path / "tables" / "b.csv")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--yes", "--json")
    told = json.loads(done.stdout)
    assert told["refused"] is None
    assert [
        remark for remark in told["remarks"] if remark.startswith("b.csv, joint 0: it holds the same rows as a.csv")
    ]
    assert all(f"remark: {remark}" in done.stderr for remark in told["remarks"])
    assert done.stderr.rstrip().endswith(f"next: haptid check {tmp_path / 'made'}")


@pytest.mark.parametrize("flag", ["--yes", "--measured"])
def test_runs_whose_names_say_so_are_kept_from_every_fit_without_a_terminal(tmp_path: Path, flag: str):
    write_pendulum(tmp_path / "tables")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", flag)
    assert done.returncode == 0, done.stderr
    assert "  kept from every fit: val_1.csv, val_2.csv (--validate)" in done.stdout
    assert [run.use for run in read_campaign(tmp_path / "made").runs] == ["fit", "validate", "validate"]


def test_nothing_is_told_of_runs_kept_where_a_flag_names_them(tmp_path: Path):
    write_pendulum(tmp_path / "tables")
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured", "--validate", "val_1.csv")
    assert "assumed" not in done.stdout
    assert [run.use for run in read_campaign(tmp_path / "made").runs] == ["fit", "validate", "fit"]


def test_a_torque_without_a_number_is_that_of_the_only_axis(tmp_path: Path):
    """The angle was of joint 1 and the torque of joint 0, so that no joint had both."""
    t = 0.005 * np.arange(600)
    columns = {"time (s)": t, "Drehwinkel Achse 1 [°]": 20.0 * np.sin(3.0 * t), "Motormoment [Nm]": np.cos(3.0 * t)}
    (tmp_path / "tables").mkdir()
    pd.DataFrame(columns).to_csv(tmp_path / "tables" / "a.csv", index=False)
    done = run_init(tmp_path / "tables", "--out", tmp_path / "made", "--measured", "--device", "single_joint")
    assert done.returncode == 0, done.stderr
    (run,) = read_campaign(tmp_path / "made").runs
    assert run.free_joints == (1,)
    np.testing.assert_allclose(run.u[:, 0], np.cos(3.0 * t), atol=1e-9)
