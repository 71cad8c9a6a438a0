"""Recordings of other programs become campaigns, and damaged ones end in one line."""

from __future__ import annotations

import bz2
import json
import math
import os
import re
import shutil
import struct
import sys
import tomllib
import zlib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy.io import savemat

from haptid.measurement import new
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.naming.lacking_columns import tell_how_to_name
from haptid.measurement.new import main
from haptid.measurement.recordings import bam_log, joint_states, mat_file, mcap_file, recording, rosbag
from haptid.measurement.recordings.one_run import recording_of
from haptid.measurement.recordings.recording import recordings_in
from haptid.measurement.tables.damage import damage_in_one_line
from haptid.measurement.values.warning import CampaignWarning
from haptid.support.errors import InputError
from tests.measurement.recordings.mat_files import mat73
from tests.real_data import DATA

ROWS = 60
T = np.arange(ROWS) * 0.01
TORQUE = 0.2 * np.cos(3.0 * T)
POSITION = 0.7 * np.sin(3.0 * T)
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
START_NS = 1_700_000_000_000_000_000


def made(folder: Path, *more: str) -> tuple[dict[str, Any], str]:
    """Content of the campaign.toml that the command makes of a folder, and what it says."""
    out = folder.parent / "made"
    done = CliRunner().invoke(main, [str(folder), "--out", str(out), "--synthetic", *more], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return tomllib.loads((out / "campaign.toml").read_text(encoding="utf-8")), done.output


def refusal(read: Callable[[], object]) -> str:
    with pytest.raises(InputError) as caught:
        read()
    text = str(caught.value)
    assert "\n" not in text
    return text


def lacking(extra: str, where: str) -> None:
    raise InputError(where, expected=f"an environment with the extra '{extra}'", got="not")


def end_process(_content: bytes) -> None:
    os._exit(139)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "logs").mkdir()
    return tmp_path / "logs"


# MATLAB


@pytest.mark.parametrize("compressed", [True, False])
def test_vectors_of_a_mat_file_are_the_columns(folder: Path, compressed: bool):
    variables = {"time_s": T, "Torque_Nm": TORQUE, "angle_deg": np.degrees(POSITION), "rate": 100.0, "note": "arm"}
    savemat(folder / "swing.mat", variables, do_compression=compressed)
    content, _ = made(folder)
    assert [run["file"] for run in content["runs"]] == ["swing.csv"]
    (run,) = read_campaign(folder.parent / "made").runs
    np.testing.assert_allclose(run.y[:, 0], POSITION, atol=1e-12)
    np.testing.assert_array_equal(run.u[:, 0], TORQUE)


def test_fields_of_a_structure_and_columns_of_a_matrix(folder: Path):
    q = np.column_stack([POSITION, 2 * POSITION])
    savemat(folder / "a.mat", {"log": {"t": T, "q": q}, "other": np.zeros(ROWS + 1)})
    (one,) = recordings_in(folder)
    assert one.table.columns == ("t", "q_0", "q_1")
    np.testing.assert_array_equal(one.table.numbers("q_1"), 2 * POSITION)


def test_mat_files_of_version_4(folder: Path):
    savemat(folder / "old.mat", {"t": T, "q": POSITION}, format="4")
    (one,) = recordings_in(folder)
    np.testing.assert_array_equal(one.table.numbers("q"), POSITION)


def test_a_vector_of_another_length_is_left_out_and_named(folder: Path):
    savemat(folder / "swing.mat", {"time_s": T, "position_0_rad": POSITION, "torque_0_Nm": TORQUE, "temp": T[:30]})
    (one,) = recordings_in(folder)
    assert "temp" not in one.table.columns
    assert one.about == "left out for their length: temp (30 values)"


def test_structures_with_the_same_fields_keep_their_names(folder: Path):
    """The elbow's position stood beside the shoulder's torque, without a word."""
    joint = {"position_rad": POSITION, "torque_Nm": TORQUE}
    savemat(folder / "swing.mat", {"time_s": T, "shoulder": joint, "elbow": {"position_rad": 2 * POSITION}})
    table = recordings_in(folder)[0].table
    assert set(table.columns) == {"time_s", "shoulder.position_rad", "shoulder.torque_Nm", "elbow.position_rad"}
    np.testing.assert_array_equal(table.frame["elbow.position_rad"], 2 * POSITION)
    code = CliRunner().invoke(main, [str(folder), "--measured", "--out", str(folder.parent / "made")]).exit_code
    assert code == 2  # whose torque it is, nobody says


def test_damaged_mat_files_are_refused_in_one_line(folder: Path):
    path = folder / "a.mat"
    savemat(path, {"t": T, "q": POSITION}, do_compression=True)
    whole = path.read_bytes()
    for content in (b"", b"hello", whole[:100], whole[:-40], whole[:140] + bytes(40) + whole[180:], bytes(400)):
        path.write_bytes(content)
        assert str(path) in refusal(lambda: mat_file.read_mat(path))


def test_a_damaged_mat_file_prints_nothing(folder: Path, capfd: pytest.CaptureFixture[str]):
    path = folder / "a.mat"
    savemat(path, {"t": T, "q": POSITION}, format="4")
    whole = path.read_bytes()
    path.write_bytes(struct.pack("<i", 2000) + whole[4:])  # the order of bytes of a VAX, of which SciPy warns
    mat_file.read_mat(path)
    assert capfd.readouterr() == ("", "")


def test_a_mat_file_that_ends_its_reader_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch):
    # Some damaged files end SciPy's compiled reader by a segmentation fault.
    path = folder / "a.mat"
    savemat(path, {"t": T, "q": POSITION})
    monkeypatch.setattr(mat_file, "load_variables", end_process)
    text = refusal(lambda: mat_file.read_mat(path))
    assert "expected a MATLAB file, got a damaged file (BrokenProcessPool); save it again" in text


# MATLAB 7.3


@pytest.mark.parametrize("compressed", [True, False])
def test_vectors_of_a_mat_file_of_version_7_3_are_the_columns(folder: Path, compressed: bool):
    variables = {"time_s": T, "Torque_Nm": TORQUE, "angle_deg": np.degrees(POSITION), "rate": 100.0, "note": "x" * ROWS}
    mat73(folder / "swing.mat", variables, **({"compression": "gzip", "chunks": True} if compressed else {}))
    content, _ = made(folder)
    assert [run["file"] for run in content["runs"]] == ["swing.csv"]
    (run,) = read_campaign(folder.parent / "made").runs
    np.testing.assert_allclose(run.y[:, 0], POSITION, atol=1e-12)
    np.testing.assert_array_equal(run.u[:, 0], TORQUE)


def test_structures_and_matrices_of_version_7_3(folder: Path):
    mat73(folder / "a.mat", {"log": {"t": T, "q": np.column_stack([POSITION, 2 * POSITION])}, "on": T > 0.1})
    (one,) = recordings_in(folder)
    assert set(one.table.columns) == {"t", "q_0", "q_1", "on"}
    np.testing.assert_array_equal(one.table.numbers("q_1"), 2 * POSITION)


def test_damaged_mat_files_of_version_7_3_are_refused_in_one_line(folder: Path):
    path = folder / "a.mat"
    mat73(path, {"t": T, "q": POSITION}, compression="gzip", chunks=True)
    whole = path.read_bytes()
    for content in (whole[:200], whole[:600], whole[:-40], whole[:512] + bytes(100) + whole[612:]):
        path.write_bytes(content)
        assert "expected a MATLAB file, got a damaged file" in refusal(lambda: mat_file.read_mat(path))


def test_a_mat_file_of_version_7_3_reads_no_other_file(folder: Path):
    h5py = pytest.importorskip("h5py")
    secret, path = folder.parent / "secret.h5", folder / "a.mat"
    with h5py.File(secret, "w") as file:
        file["q"] = POSITION
    mat73(path, {"t": T, "u": TORQUE})
    with h5py.File(path, "r+") as file:
        file["q"] = h5py.ExternalLink(str(secret), "/q")
        file["soft"] = h5py.SoftLink("/t")
        raw = file.create_dataset("raw", (ROWS,), dtype="f8", external=[(str(secret), 0, 8 * ROWS)])
        assert raw.external
        layout = h5py.VirtualLayout((ROWS,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "q", (ROWS,))
        file.create_virtual_dataset("virtual", layout)
    (one,) = recordings_in(folder)
    assert set(one.table.columns) == {"t", "u"}


def test_a_mat_file_of_version_7_3_that_unpacks_to_gigabytes_is_refused(folder: Path):
    mat73(folder / "a.mat", {"t": T})
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "a.mat", "r+") as file:
        file.create_dataset("q", (1 << 30,), dtype="f8", chunks=(1 << 20,), compression="gzip")
    assert "expected a table that unpacks to at most 250 times" in refusal(lambda: recordings_in(folder))


def test_a_mat_file_of_version_7_3_needs_its_extra(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(mat_file, "need", lacking)
    (folder / "a.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(600, b" "))
    assert "expected an environment with the extra 'matlab'" in refusal(lambda: recordings_in(folder))


def test_a_mat_file_that_unpacks_to_gigabytes_is_refused(folder: Path):
    path = folder / "a.mat"
    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(bytes(1 << 20)) for _ in range(100)) + packer.flush()
    header = b"MATLAB 5.0 MAT-file".ljust(124, b" ") + struct.pack("<H", 0x0100) + b"IM"
    path.write_bytes(header + struct.pack("<II", 15, len(packed)) + packed)
    assert "expected a table that unpacks to at most 250 times" in refusal(lambda: mat_file.read_mat(path))


def test_a_mat_file_without_vectors_of_one_length_says_what_it_holds(folder: Path):
    savemat(folder / "a.mat", {"t": T, "q": POSITION[:-1], "n": 3.0})
    text = refusal(lambda: recordings_in(folder))
    assert "expected vectors of one length, got t of 60, q of 59" in text


# BAM


def bam(motor: str = "xl330") -> dict[str, Any]:
    entries = [
        {
            "timestamp": float(t),
            "position": float(q),
            "speed": 0.0,
            "goal_position": float(q) + 0.1,
            "load": 65436 if row % 2 else 177,
            "input_volts": 7.4,
            "temp": 28,
            "torque_enable": True,
        }
        for row, (t, q) in enumerate(zip(T, POSITION, strict=True))
    ]
    return {"mass": 0.49, "length": 0.1, "kp": 100, "vin": 7.4, "motor": motor, "trajectory": "sin", "entries": entries}


def test_a_log_of_bam_becomes_a_driven_joint(folder: Path):
    (folder / "a.json").write_text(json.dumps(bam()))
    content, said = made(folder)
    assert content["joint"]["0"]["drive"] == {"kind": "duty"}
    assert "a.csv: motor xl330, kp 100, vin 7.4, mass 0.49, length 0.1, trajectory sin" in said
    table = pd.read_csv(folder.parent / "made" / "a.csv")
    np.testing.assert_allclose(table["duty_0"].iloc[:2], [177 / 885, -100 / 885])
    np.testing.assert_array_equal(table["position_0_rad"], POSITION)
    np.testing.assert_allclose(table["reference_0_rad"], POSITION + 0.1)


def test_the_load_of_another_servo_is_left_as_it_is(folder: Path):
    (folder / "a.json").write_text(json.dumps(bam("mx106")))
    (one,) = recordings_in(folder)
    assert "duty_0" not in one.table.columns
    assert one.table.numbers("load")[1] == 65436


def test_damaged_logs_of_bam_are_refused_in_one_line(folder: Path):
    path = folder / "a.json"
    text = json.dumps(bam())
    short = bam() | {"entries": bam()["entries"][:3]}
    without = bam()
    del without["entries"][7]["position"]
    for content, told in (
        (text[: len(text) // 2], "a.json, line 1"),
        ("{}", "expected a log of BAM, with a list of entries, got the keys none"),
        ('{"entries": [1, 2]}', "with a list of entries"),
        ("[1, 2]", "expected a log of BAM"),
        (json.dumps(short), "expected at least 8 rows, got 3"),
        (json.dumps(without), "entries[7].position: expected a number, got none"),
        ("[" * 100_000, "levels of brackets"),
    ):
        path.write_text(content)
        assert told in refusal(lambda: bam_log.read_bam_log(path)), content[:40]
    path.write_bytes(b"\xff\xfe{")
    assert "text in UTF-8" in refusal(lambda: bam_log.read_bam_log(path))


def refused(folder: Path, *flags: str) -> str:
    """What the command says where it refuses a folder."""
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--measured", *flags])
    assert done.exit_code == 2, done.output
    return done.stderr


def test_an_error_in_a_recording_names_the_file_that_is_there(folder: Path):
    """It named line 9 of a.csv, of a draft that was gone."""
    log = bam("mx106")
    log["entries"][7]["load"] = 1770
    log["entries"] = [entry | {"load": min(entry["load"], 1770)} for entry in log["entries"]]
    for entry in log["entries"][:7]:
        entry["load"] = 500
    (folder / "a.json").write_text(json.dumps(log))
    assert f"{folder / 'a.json'}, entries[7], column duty_0: expected" in refused(folder, "--map", "load=duty_0*0.001")
    (folder / "a.json").unlink()
    duty = np.where(np.arange(ROWS) < 7, 0.5, 1.77)
    savemat(folder / "a.mat", {"time_s": T, "position_0_rad": POSITION, "duty_0": duty, "supply_V": 12.0 + 0.0 * T})
    assert f"error: {folder / 'a.mat'}, row 8, column duty_0: expected" in refused(folder)


def test_an_error_in_a_table_names_its_line_also_where_rows_were_left_out(folder: Path):
    rows = [f"{t:.2f};{0.5 if k < 9 else 1.77};{q:.4f};12" for k, (t, q) in enumerate(zip(T, POSITION, strict=True))]
    rows[3] = rows[3].partition(";")[0] + ";;;"
    (folder / "a.csv").write_text("\n".join(["a logger", "time_s;duty_0;position_0_rad;supply_V", *rows]) + "\n")
    assert f"error: {folder / 'a.csv'}, line 12, column duty_0: expected" in refused(folder)


@pytest.mark.real("bam_xl330")
def test_real_logs_of_bam_become_a_campaign(folder: Path):
    # The set's tables are these logs with other names; they are turned back.
    names = {
        "time_s": "timestamp",
        "goal_rad": "goal_position",
        "position_rad": "position",
        "velocity_rad_s": "speed",
        "load_raw": "load",
        "supply_V": "input_volts",
        "temperature_C": "temp",
        "torque_enabled": "torque_enable",
    }
    for kp in (100, 400):
        table = pd.read_csv(DATA / "bam_xl330" / f"kp{kp}_sin_sin.csv").rename(columns=names)
        log = bam() | {"kp": kp, "entries": table.to_dict("records")}
        (folder / f"kp{kp}.json").write_text(json.dumps(log))
    content, _ = made(folder, "--validate", "kp400.csv")
    assert [(run["file"], run["use"]) for run in content["runs"]] == [("kp100.csv", "fit"), ("kp400.csv", "validate")]
    assert np.abs(pd.read_csv(folder.parent / "made" / "kp100.csv")["duty_0"]).max() < 1.0
    assert len(read_campaign(folder.parent / "made").runs) == 2


# LeRobot


def lerobot(
    folder: Path, *, names: Any = ("shoulder.pos", "elbow.pos"), episodes: int = 2, driven: str = "observation.effort"
) -> Path:
    pytest.importorskip("pyarrow")
    (folder / "meta").mkdir()
    (folder / "data" / "chunk-000").mkdir(parents=True)
    feature = {"dtype": "float32", "shape": [2], "names": names if isinstance(names, dict) else list(names)}
    features = {"observation.state": feature, driven: feature, "timestamp": {"names": None}}
    (folder / "meta" / "info.json").write_text(json.dumps({"codebase_version": "v3.0", "features": features}))
    frames = []
    for episode in range(episodes):
        frames.append(
            pd.DataFrame(
                {
                    "observation.state": list(np.column_stack([POSITION, 0 * POSITION]).astype("float32")),
                    driven: list(np.column_stack([TORQUE, 0 * TORQUE]).astype("float32")),
                    "timestamp": T.astype("float32"),
                    "frame_index": np.arange(ROWS),
                    "episode_index": episode,
                    "index": np.arange(ROWS) + episode * ROWS,
                    "task_index": 0,
                }
            )
        )
    path = folder / "data" / "chunk-000" / "file-000.parquet"
    pd.concat(frames).to_parquet(path, index=False)
    return path


def test_episodes_of_lerobot_become_runs(folder: Path):
    lerobot(folder)
    maps = (
        "--map",
        "observation.state.shoulder.pos=position_0_rad",
        "--map",
        "observation.effort.shoulder.pos=torque_0_Nm",
    )
    content, said = made(folder, *maps, "--validate", "*_000001.csv")
    assert "kept and not used: observation.state.elbow.pos, observation.effort.elbow.pos" in said
    assert [(run["file"], run["use"]) for run in content["runs"]] == [
        ("file-000_episode_000000.csv", "fit"),
        ("file-000_episode_000001.csv", "validate"),
    ]
    with pytest.warns(CampaignWarning, match="kept and not used"):
        run = read_campaign(folder.parent / "made").runs[0]
    np.testing.assert_allclose(run.u[:, 0], TORQUE, atol=1e-7)
    np.testing.assert_allclose(run.y[:, 0], POSITION, atol=1e-7)


def test_names_of_elements_may_be_grouped_or_lacking(folder: Path):
    lerobot(folder, names={"motors": ["a", "b"]}, episodes=1)
    (one,) = recordings_in(folder)
    assert "observation.state.b" in one.table.columns
    (folder / "meta" / "info.json").write_text("{}")
    (one,) = recordings_in(folder)
    assert "observation.state.1" in one.table.columns
    assert "task_index" not in one.table.columns


def test_units_that_nothing_states_are_not_guessed(folder: Path):
    lerobot(folder)
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic"])
    assert done.exit_code == 2
    assert "episode_000000: expected columns time_s, torque_<j>_Nm, position_<j>_rad" in done.output
    assert "name them, as in --map 'observation.effort.shoulder.pos=torque_0_Nm'" in done.output


def test_state_and_action_alone_are_refused_with_what_suffices(folder: Path):
    lerobot(folder, driven="action")
    maps = ["--map", "observation.state.elbow.pos=position_0_rad", "--map", "action.elbow.pos=reference_0_rad"]
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic", *maps])
    assert done.exit_code == 2, done.output
    told = "torque, current, voltage or duty of joint 0, got its position and reference alone; log one of them too, or "
    assert f"{told}state the position controller: [joint.0.controller] in a campaign.toml" in done.output
    assert len(done.output.splitlines()) == 1


@pytest.mark.parametrize("names", [("shoulder.pos", "elbow.pos"), ("main_shoulder_pan", "main_elbow"), ("0", "1")])
@pytest.mark.parametrize("asks", [True, False])
def test_state_and_action_are_refused_at_once_without_a_torque_for_either(
    folder: Path, names: tuple[str, str], asks: bool, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(new, "_can_ask", lambda: asks)
    lerobot(folder, driven="action", names=names)
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic"])
    assert done.exit_code == 2, done.output
    # A long path leaves room for the ends of the columns' names.
    told = "torque, current, voltage or duty of joint 0, got obs.* alone; log one of them too, or state the position"
    assert re.search(told, done.output) is not None
    assert "--map" not in done.output
    assert len(done.output.splitlines()) == 1


def test_state_and_action_beside_a_current_ask_for_the_current(folder: Path):
    columns = {"time_s": T, "observation.state": POSITION, "action": POSITION, "observation.current": TORQUE}
    pd.DataFrame(columns).to_csv(folder / "a.csv", index=False)
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic"])
    assert done.exit_code == 2, done.output
    assert "name them, as in --map 'observation.current=current_0_A'" in done.output


@pytest.mark.parametrize("name", ["observation.state.m", "pos_m_raw", "action", "setpoint", "angle i"])
def test_no_torque_is_proposed_for_the_name_of_a_position(name: str):
    told = tell_how_to_name(["torque"], ["time_s", name, "position_0_rad"], [0], None)
    assert told == "no torque: add torque_0_Nm (zeros of a free swing)"


def test_damaged_data_sets_of_lerobot_are_refused_in_one_line(folder: Path):
    path = lerobot(folder)
    whole = path.read_bytes()
    for content in (b"", whole[:200], whole[: len(whole) // 2], b"PAR1" + bytes(100) + b"PAR1"):
        path.write_bytes(content)
        assert "expected a table in Parquet, got a damaged file" in refusal(lambda: recordings_in(folder))
    pd.DataFrame({"timestamp": T}).to_parquet(path)
    assert "expected a column episode_index" in refusal(lambda: recordings_in(folder))
    path.unlink()
    assert "expected Parquet files of a LeRobot data set, got none" in refusal(lambda: recordings_in(folder))
    (folder / "meta" / "info.json").write_text("{")
    assert "info.json" in refusal(lambda: recordings_in(folder))


# MCAP


def ros2(path: Path, topics: tuple[str, ...] = ("/joint_states",), names: tuple[str, ...] = ("waist", "elbow")) -> None:
    writer_of = pytest.importorskip("mcap_ros2.writer")
    with path.open("wb") as stream:
        writer = writer_of.Writer(stream)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        other = writer.register_msgdef("std_msgs/msg/Float64", "float64 data\n")
        for row in range(ROWS):
            at = START_NS + round(1e9 * T[row])
            stamp = {"sec": at // 10**9, "nanosec": at % 10**9}
            values = {"position": [0.0, POSITION[row]], "velocity": [], "effort": [0.0, TORQUE[row]]}
            message = {"header": {"stamp": stamp, "frame_id": ""}, "name": list(names), **values}
            for topic in topics:
                writer.write_message(topic, schema, message, log_time=at + 5_000_000, publish_time=at)
            writer.write_message("/temperature", other, {"data": 20.0}, log_time=at, publish_time=at)
        writer.finish()


def test_joint_states_of_ros_2_become_a_run(folder: Path):
    ros2(folder / "swing.mcap")
    content, said = made(folder, "--free", "1")
    assert [(run["file"], run["free_joints"]) for run in content["runs"]] == [("swing.csv", [1])]
    assert "swing.csv: topic /joint_states, joints 0 waist, 1 elbow" in said
    run = read_campaign(folder.parent / "made").runs[0]
    np.testing.assert_allclose(run.t, T, atol=1e-9)
    np.testing.assert_array_equal(run.y[:, 0], POSITION)
    np.testing.assert_array_equal(run.u[:, 0], TORQUE)


def test_every_topic_of_joint_states_is_a_run(folder: Path):
    ros2(folder / "a.mcap", ("/left/joint_states", "/right/joint_states"))
    names = [one.table.file_name for one in recordings_in(folder)]
    assert names == ["a_left_joint_states.csv", "a_right_joint_states.csv"]


def test_messages_in_json(folder: Path):
    mcap_writer = pytest.importorskip("mcap.writer")
    with (folder / "a.mcap").open("wb") as stream:
        writer = mcap_writer.Writer(stream)
        writer.start()
        schema = writer.register_schema("JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/arm", "json", schema)
        for row in range(ROWS):
            data = json.dumps({"name": ["a"], "position": [POSITION[row]], "effort": [TORQUE[row]]}).encode()
            at = START_NS + round(1e9 * T[row])
            writer.add_message(channel, log_time=at, publish_time=at, data=data)
        writer.finish()
    (one,) = recordings_in(folder)
    np.testing.assert_allclose(one.table.time(), T, atol=1e-9)
    np.testing.assert_array_equal(one.table.numbers("torque_0_Nm"), TORQUE)


def test_damaged_mcap_files_are_refused_in_one_line(folder: Path):
    path = folder / "a.mcap"
    ros2(path)
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 3] ^= 0xFF
    for content in (b"", b"hello", whole[:30], whole[: len(whole) // 2], whole[:-20], bytes(flipped)):
        path.write_bytes(content)
        assert "expected a recording in MCAP, got a damaged file" in refusal(lambda: mcap_file.read_mcap(path))


def test_a_damaged_schema_prints_nothing(folder: Path, capfd: pytest.CaptureFixture[str]):
    path = folder / "a.mcap"
    mcap_writer = pytest.importorskip("mcap.writer")
    with path.open("wb") as stream:
        writer = mcap_writer.Writer(stream)
        writer.start()
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"float64[] osition__\n")
        channel = writer.register_channel("/arm", "cdr", schema)
        writer.add_message(channel, log_time=1, publish_time=1, data=bytes(40))
        writer.finish()
    assert "got a damaged file" in refusal(lambda: mcap_file.read_mcap(path))
    assert capfd.readouterr() == ("", "")


def test_an_mcap_file_without_joint_states_says_so(folder: Path):
    ros2(folder / "a.mcap", topics=())
    assert "expected messages JointState, got none" in refusal(lambda: recordings_in(folder))


def states(names: list[str], rows: int = ROWS, *, effort: bool = True) -> list[tuple[int, dict[str, Any]]]:
    """Return messages in which joint ``a`` is at 0 and ``b`` at 1, each with its position as effort."""
    at = {"a": 0.0, "b": 1.0}
    values = [at.get(name, 2.0) for name in names]
    return [(k, {"name": names, "position": values, "effort": values if effort else []}) for k in range(rows)]


def test_messages_name_their_joints_in_any_order(tmp_path: Path):
    mixed = [pair for both in zip(states(["a", "b"]), states(["b", "a"]), strict=True) for pair in both]
    (one,) = joint_states.recordings_of_topics(tmp_path / "a.mcap", {"/x": mixed})
    assert one.table.joints == ("a", "b")
    assert set(one.table.frame["position_1_rad"]) == {1.0}


def test_a_gripper_on_the_topic_of_its_arm_is_a_run_of_its_own_or_left_out(tmp_path: Path):
    arm, gripper = states(["a", "b"]), states(["finger"])
    found = joint_states.recordings_of_topics(tmp_path / "a.mcap", {"/x": [*arm, *gripper]})
    assert [one.table.file_name for one in found] == ["a_a.csv", "a_finger.csv"]
    (one,) = joint_states.recordings_of_topics(tmp_path / "a.mcap", {"/x": arm, "/y": states(["finger"], effort=False)})
    assert one.about == "topic /x; without positions and efforts and left out: /y of finger"


@pytest.mark.parametrize(
    ("effort", "got", "todo"),
    [
        ([], "positions of /x, efforts of none", "record the torque as effort"),
        ([math.nan, math.nan], "positions of /x, efforts of none", "record the torque as effort"),
    ],
)
def test_joint_states_without_efforts_are_refused(tmp_path: Path, effort: list[float], got: str, todo: str):
    messages = [(k, {"name": ["a", "b"], "position": [0.0, 1.0], "effort": effort}) for k in range(ROWS)]
    text = refusal(lambda: joint_states.recordings_of_topics(tmp_path / "a.mcap", {"/x": messages}))
    assert f"expected positions and efforts of joints on one topic, got {got}; {todo}" in text


def test_commands_and_states_on_two_topics_are_to_be_brought_together(tmp_path: Path):
    states_alone = states(["a"], effort=False)
    commands = [(k, {"name": ["a"], "position": [], "effort": [0.1]}) for k in range(ROWS)]
    topics = {"/states": states_alone, "/commands": commands}
    text = refusal(lambda: joint_states.recordings_of_topics(tmp_path / "a.mcap", topics))
    assert "got positions of /states, efforts of /commands; write both to one table" in text


def test_a_message_without_a_value_of_each_joint_is_refused(tmp_path: Path):
    messages = [*states(["a", "b"]), (ROWS, {"name": ["a", "b"], "position": [1.0], "effort": [0.0, 0.0]})]
    text = refusal(lambda: joint_states.recordings_of_topics(tmp_path / "a.mcap", {"/x": messages}))
    assert f"message {ROWS + 1}: expected a position of each of a, b, got 1 values of a, b" in text


def test_joints_of_a_recording_have_the_numbers_of_the_devices_by_their_names(folder: Path):
    """An alphabetical message swapped shoulder and elbow without a word."""
    ros2(folder / "swing.mcap", names=("elbow", "shoulder"))
    ros2(folder / "turn.mcap", names=("shoulder", "elbow"))
    _, said = made(folder, "--device", "double_pendulum", "--free", "0,1")
    assert "swing.csv: topic /joint_states, joints 0 elbow, 1 shoulder" in said
    assert "turn.csv: topic /joint_states, joints 0 elbow, 1 shoulder" in said
    swing, turn = read_campaign(folder.parent / "made").runs
    assert [np.ptp(run.y, axis=0).argmax() for run in (swing, turn)] == [0, 1]


def test_an_mcap_file_needs_its_extra(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(mcap_file, "need", lacking)
    (folder / "a.mcap").write_bytes(b"")
    assert "expected an environment with the extra 'mcap'" in refusal(lambda: recordings_in(folder))


# Rosbags


def bag_of(path: Path, version: int, compression: str = "", topics: tuple[str, ...] = ("/joint_states",)) -> Path:
    """Write a bag of ROS 1 (a file) or ROS 2 (a folder with SQLite), and return the file with the messages."""
    pytest.importorskip("rosbags")
    from rosbags import rosbag1, rosbag2  # noqa: PLC0415
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    types = store.types
    State, Header = types["sensor_msgs/msg/JointState"], types["std_msgs/msg/Header"]
    Time, Number = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Float64"]
    writer: Any = rosbag1.Writer(path) if version == 1 else rosbag2.Writer(path, version=8)
    if compression:
        writer.set_compression(rosbag1.Writer.CompressionFormat[compression])
    serialize = store.serialize_ros1 if version == 1 else store.serialize_cdr
    with writer:
        kind = State.__msgtype__
        connections = [writer.add_connection(topic, kind, typestore=store) for topic in topics]
        other = writer.add_connection("/temperature", Number.__msgtype__, typestore=store)
        for row in range(ROWS):
            at = START_NS + round(1e9 * T[row])
            stamp = Time(sec=at // 10**9, nanosec=at % 10**9)
            header = Header(**({"seq": row} if version == 1 else {}), stamp=stamp, frame_id="")
            state = State(
                header=header, name=["waist", "elbow"], position=np.array([0.0, POSITION[row]]),
                velocity=np.zeros(0), effort=np.array([0.0, TORQUE[row]]),
            )  # fmt: skip
            for connection in connections:
                writer.write(connection, at + 5_000_000, serialize(state, kind))
            writer.write(other, at, serialize(Number(data=20.0), Number.__msgtype__))
    return path if version == 1 else next(path.glob("*.db3"))


@pytest.mark.parametrize("compression", ["", "BZ2", "LZ4"])
def test_joint_states_of_ros_1_become_a_run(folder: Path, compression: str):
    bag_of(folder / "swing.bag", 1, compression)
    content, said = made(folder, "--free", "1")
    assert [(run["file"], run["free_joints"]) for run in content["runs"]] == [("swing.csv", [1])]
    assert "swing.csv: topic /joint_states, joints 0 waist, 1 elbow" in said
    run = read_campaign(folder.parent / "made").runs[0]
    np.testing.assert_allclose(run.t, T, atol=1e-9)
    np.testing.assert_array_equal(run.y[:, 0], POSITION)
    np.testing.assert_array_equal(run.u[:, 0], TORQUE)


@pytest.mark.parametrize("place", ["the bag's own folder", "a folder of bags", "a file alone"])
def test_joint_states_of_ros_2_in_sqlite_become_a_run(folder: Path, place: str):
    messages = bag_of(folder / "swing", 2)
    if place == "a file alone":
        messages = messages.rename(folder / "swing.db3")
        shutil.rmtree(folder / "swing")
    given = messages.parent if place == "the bag's own folder" else folder
    (one,) = recordings_in(given)
    assert one.table.file_name == "swing.csv"
    np.testing.assert_allclose(one.table.time(), T, atol=1e-9)
    np.testing.assert_array_equal(one.table.numbers("position_1_rad"), POSITION)
    np.testing.assert_array_equal(one.table.numbers("torque_1_Nm"), TORQUE)


@pytest.mark.parametrize("version", [1, 2])
def test_a_bag_without_joint_states_says_so(folder: Path, version: int):
    bag_of(folder / "a.bag" if version == 1 else folder / "a", version, topics=())
    assert "expected messages JointState, got none" in refusal(lambda: recordings_in(folder))


@pytest.mark.parametrize("version", [1, 2])
def test_damaged_bags_are_refused_in_one_line(folder: Path, version: int):
    path = bag_of(folder / "a.bag" if version == 1 else folder / "a", version)
    whole = path.read_bytes()
    gone = whole.replace(b"messages", b"massages")
    for content in (b"", b"hello", whole[:30], whole[: len(whole) // 2], gone if version == 2 else whole[:-20]):
        path.write_bytes(content)
        assert "expected a bag of ROS, got a damaged file" in refusal(lambda: rosbag.read_rosbag(path))


def test_chunks_of_a_bag_are_counted_while_they_are_unpacked(folder: Path):
    frame = pytest.importorskip("lz4.frame")
    path = folder / "a.bag"
    for packer in (bz2, frame):
        bomb = packer.compress(bytes(70 << 20))
        path.write_bytes(bomb)
        chunk = SimpleNamespace(decompressor=packer.decompress, datapos=0, datasize=len(bomb))
        assert max(rosbag._unpacked_bytes(path, SimpleNamespace(chunks={0: chunk}))) == 70 << 20


def test_a_bag_that_unpacks_to_gigabytes_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch):
    path = bag_of(folder / "a.bag", 1, "BZ2")
    monkeypatch.setattr(rosbag, "_unpacked_bytes", lambda *_: iter([1 << 20, 1 << 30]))
    assert "expected a table that unpacks to at most 250 times" in refusal(lambda: rosbag.read_rosbag(path))


@pytest.mark.parametrize("values", ['"x"', "[null]", '["x"]', "[1e999, {}]", "3", "[1, 2]", "{}"])
def test_values_that_are_no_numbers_are_refused(folder: Path, values: str):
    mcap_writer = pytest.importorskip("mcap.writer")
    with (folder / "a.mcap").open("wb") as stream:
        writer = mcap_writer.Writer(stream)
        writer.start()
        schema = writer.register_schema("JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/arm", "json", schema)
        for row in range(ROWS):
            position = "[1.0]" if row < ROWS // 2 else values
            data = f'{{"name": ["a"], "position": {position}, "effort": [0.5]}}'.encode()
            writer.add_message(channel, log_time=row, publish_time=row, data=data)
        writer.finish()
    assert f"message {ROWS // 2 + 1}: expected" in refusal(lambda: recordings_in(folder))


def test_a_bag_needs_its_extra(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(rosbag, "need", lacking)
    (folder / "a.bag").write_bytes(b"")
    assert "expected an environment with the extra 'rosbags'" in refusal(lambda: recordings_in(folder))


# Libraries


@pytest.mark.parametrize(
    ("name", "library", "content", "raised"),
    [
        ("a.mat", "h5py", b"MATLAB 7.3 MAT-file", "ImportError('libhdf5.so.310: cannot open shared object file')"),
        ("a.mcap", "mcap", b"", "ImportError('cannot import name x from mcap')"),
        ("a.bag", "rosbags", b"", "AttributeError('module numpy has no attribute product')"),
        ("a.parquet", "pyarrow", b"PAR1", "OSError('libarrow.so: file too short')"),
    ],
)
def test_a_library_that_cannot_be_imported_is_told_with_its_reason(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, library: str, content: bytes, raised: str
):
    """It read as a damaged file, which was sound."""
    broken = folder.parent / "broken" / library
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text(f"import sys\nsys.stderr.write('noise')\nraise {raised}\n")
    monkeypatch.syspath_prepend(str(broken.parent))
    for module in [module for module in sys.modules if module.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, module)
    (folder / name).write_bytes(content)
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic"])
    assert done.exit_code == 2
    kind, _, reason = raised.rstrip("')").partition("('")
    assert f"{name}: expected a library {library} that can be imported, got an import that fails with " in done.output
    assert f"{kind}: {reason}; install it again: pip install --force-reinstall {library}" in done.output
    assert "noise" not in done.output


def test_a_part_of_a_library_that_cannot_be_imported_later_is_no_damage(tmp_path: Path):
    def read() -> None:
        with damage_in_one_line(tmp_path / "a.mcap", "a recording", "copy it again"):
            raise ModuleNotFoundError("No module named 'zstandard'", name="zstandard")

    assert "expected a library zstandard that can be imported" in refusal(read)


# Folders


def test_columns_that_end_with_a_joints_number_are_renumbered(folder: Path):
    one = recording_of(folder / "a.mcap", {"duty_0": TORQUE, "position_0_rad": POSITION}, joints=("elbow",))
    first = recording_of(folder / "b.mcap", {"duty_0": TORQUE, "position_0_rad": POSITION}, joints=("waist",))
    made_alike = recording._numbered_alike([first, one])
    assert made_alike[1].table.columns == ("duty_1", "position_1_rad")


def test_recordings_beside_tables_are_left_alone_and_named(folder: Path):
    """They were passed over without a word."""
    savemat(folder / "a.mat", {"t": T, "q": POSITION})
    (folder / "notes.json").write_text('{"entries": 3}')
    (folder / "servo.json").write_text(json.dumps(bam()))
    (folder / "notes.txt").write_text("a swing of the arm\n")
    table = pd.DataFrame({"time_s": T, "torque_0_Nm": TORQUE, "position_0_rad": POSITION})
    table.to_csv(folder / "b.csv", index=False)
    table.to_csv(folder / "c.txt", index=False, sep="\t")
    (folder / "d.xlsx").touch()
    content, said = made(folder)
    assert [run["file"] for run in content["runs"]] == ["b.csv"]
    assert (
        "not read beside the tables: c.txt, a.mat, servo.json, d.xlsx; if other runs, make a campaign of them in a "
        "folder of their own\n"
    ) in said


def test_a_folder_of_tables_alone_says_nothing_of_recordings(folder: Path):
    pd.DataFrame({"time_s": T, "torque_0_Nm": TORQUE, "position_0_rad": POSITION}).to_csv(folder / "b.csv", index=False)
    assert "not read beside" not in made(folder)[1]


def test_bags_and_data_sets_beside_tables_are_named(folder: Path):
    for name in ("bag/metadata.yaml", "bag/bag_0.db3", "meta/info.json", "old.bag/readme"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("{}")
    assert recording.names_of_recordings(folder) == ["bag/bag_0.db3", "meta/info.json"]


def test_two_recordings_of_one_name_are_refused(folder: Path):
    savemat(folder / "a.mat", {"time_s": T, "torque_Nm": TORQUE, "q_rad": POSITION})
    (folder / "a.json").write_text(json.dumps(bam()))
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic"])
    assert done.exit_code == 2
    assert "expected one run a.csv, got several" in done.output
