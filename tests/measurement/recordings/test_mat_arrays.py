"""Arrays of structures and of cells in MATLAB files: runs, joints, or named and left out."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import matlab as scipy_matlab

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.new import main
from haptid.measurement.recordings import mat_file
from haptid.measurement.recordings.mat_values import Unread
from haptid.measurement.recordings.recording import recordings_in
from haptid.support.errors import InputError
from tests.measurement.recordings.mat_files import mat5, mat73

ROWS = 60
T = np.arange(ROWS) * 0.01
TORQUE = 0.2 * np.cos(3.0 * T)
POSITION = 0.7 * np.sin(3.0 * T)


def made(folder: Path, *more: str) -> tuple[dict[str, Any], str]:
    """Content of the campaign.toml that the command makes of a folder, and what it says."""
    out = folder.parent / "made"
    done = CliRunner().invoke(main, [str(folder), "--out", str(out), "--synthetic", *more], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return tomllib.loads((out / "campaign.toml").read_text(encoding="utf-8")), done.output


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "logs").mkdir()
    return tmp_path / "logs"


@pytest.fixture(params=[mat5, mat73], ids=["version 5", "version 7.3"])
def write(request: pytest.FixtureRequest) -> Callable[[Path, dict[str, Any]], None]:
    return request.param


def element(rows: int = ROWS, by: float = 1.0) -> dict[str, Any]:
    return {"time_s": T[:rows], "q_rad": by * POSITION[:rows], "tau_Nm": TORQUE[:rows], "label": "swing"}


def test_elements_of_an_array_of_structures_are_runs(folder: Path, write: Any):
    write(folder / "arm.mat", {"swing": [element(), element(50, 2.0)], "rate": 100.0})
    content, said = made(folder)
    assert [run["file"] for run in content["runs"]] == ["arm_swing_1.csv", "arm_swing_2.csv"]
    assert "arm_swing_1.csv: 2 of 2 elements of swing are a run each\n" in said
    second = read_campaign(folder.parent / "made").runs[1]
    np.testing.assert_allclose(second.y[:, 0], 2 * POSITION[:50], atol=1e-12)


def test_an_array_of_structures_within_a_structure(folder: Path, write: Any):
    write(folder / "arm.mat", {"log": {"runs": [element(), element()], "rig": "arm"}})
    assert [one.table.file_name for one in recordings_in(folder)] == ["arm_log_runs_1.csv", "arm_log_runs_2.csv"]


def test_one_time_beside_runs_is_that_of_all(folder: Path, write: Any):
    write(folder / "a.mat", {"time_s": T, "trial": [{"q_rad": POSITION, "tau_Nm": TORQUE}, {"q_rad": T, "tau_Nm": T}]})
    first, second = recordings_in(folder)
    assert set(first.table.columns) == set(second.table.columns) == {"time_s", "q_rad", "tau_Nm"}


def test_joints_beside_one_time_stand_side_by_side(folder: Path, write: Any):
    joints = [{"q_rad": POSITION, "tau_Nm": TORQUE}, {"q_rad": 2 * POSITION, "tau_Nm": 2 * TORQUE}]
    write(folder / "a.mat", {"time_s": T, "joint": joints})
    (one,) = recordings_in(folder)
    names = {"time_s", "joint_0.q_rad", "joint_0.tau_Nm", "joint_1.q_rad", "joint_1.tau_Nm"}
    assert set(one.table.columns) == names
    np.testing.assert_array_equal(one.table.numbers("joint_1.q_rad"), 2 * POSITION)
    assert one.about == "elements of joint stand side by side, numbered from 0"
    (run,) = made(folder, "--device", "double_pendulum")[0]["runs"]
    assert run["free_joints"] == [0, 1]


def test_joints_that_were_logged_together_are_one_run_and_others_a_run_each(folder: Path, write: Any):
    write(folder / "a.mat", {"joint": [element(), element(by=2.0)]})
    (one,) = recordings_in(folder)
    assert set(one.table.columns) == {"time_s", "joint_0.q_rad", "joint_0.tau_Nm", "joint_1.q_rad", "joint_1.tau_Nm"}
    write(folder / "a.mat", {"joint": [element(), element(50)]})
    first, second = recordings_in(folder)
    assert set(first.table.columns) == {"time_s", "joint_0.q_rad", "joint_0.tau_Nm"}
    assert set(second.table.columns) == {"time_s", "joint_1.q_rad", "joint_1.tau_Nm"}


def test_cells_side_by_side_are_runs_or_joints(folder: Path, write: Any):
    cells = {"time_s": [T, T[:50]], "q_rad": [POSITION, POSITION[:50]], "tau_Nm": [TORQUE, TORQUE[:50]]}
    write(folder / "a.mat", {**cells, "labels": ["up", "down"]})
    assert [one.table.file_name for one in recordings_in(folder)] == ["a_run_1.csv", "a_run_2.csv"]
    write(folder / "a.mat", {"time_s": T, "q_rad": [POSITION, T], "tau_Nm": [TORQUE, T]})
    (one,) = recordings_in(folder)
    assert set(one.table.columns) == {"time_s", "q_rad_0", "q_rad_1", "tau_Nm_0", "tau_Nm_1"}


def test_cells_of_matrices_are_runs(folder: Path, write: Any):
    matrix = np.column_stack([T, POSITION, TORQUE])
    write(folder / "a.mat", {"data": [matrix, matrix[:40]]})
    first, second = recordings_in(folder)
    assert (first.table.columns, len(second.table.frame)) == (("data_0", "data_1", "data_2"), 40)


def test_what_is_in_no_run_is_named(folder: Path, write: Any):
    short = element() | {"temp": T[:20]}
    results = {"gain": T[:30], "phase": T[:30], "cube": np.zeros((4, 3, 2))}
    write(folder / "a.mat", {"swing": [element() | {"temp": T}, short], **results})
    first, second = recordings_in(folder)
    assert second.about == ""
    assert "left out for their length: swing(2).temp (20 values)" in first.about
    for told in (
        "cube (an array of 3 dimensions)",
        "gain (30 values without a time)",
        "phase (30 values without a time)",
    ):
        assert told in first.about.partition("not read and left out: ")[2]


def test_a_run_of_vectors_stands_beside_those_of_elements(folder: Path, write: Any):
    write(folder / "a.mat", {**element(40), "swing": [element(), element()]})
    assert [one.table.file_name for one in recordings_in(folder)] == ["a_swing_1.csv", "a_swing_2.csv", "a.csv"]


def test_cells_of_two_sizes_make_runs_of_their_own_names(folder: Path, write: Any):
    two = {"time_s": [T, T], "q_rad": [POSITION, T]}
    write(folder / "a.mat", {"up": two, "down": {name: [*values, T[:20]] for name, values in two.items()}})
    names = [one.table.file_name for one in recordings_in(folder)]
    assert len(set(names)) == 5


def test_an_object_of_matlab_is_named_and_a_text_is_not():
    fields = [("s0", "O"), ("s1", "O"), ("s2", "O"), ("arr", "O")]
    for kind, told in ((b"table", Unread(kind="a table of MATLAB", name="log")), (b"string", None)):
        value = scipy_matlab.MatlabOpaque(np.array([(b"log", b"MCOS", kind, None)], dtype=fields))
        assert mat_file._value(value) == told


def test_cells_that_hold_themselves_end(folder: Path):
    h5py = pytest.importorskip("h5py")
    mat73(folder / "a.mat", {"t": T, "q": [POSITION, TORQUE]})
    with h5py.File(folder / "a.mat", "r+") as file:
        file["q"][:] = np.array([file["q"].ref] * 2, dtype=h5py.ref_dtype).reshape(2, 1)
    with pytest.raises(InputError, match="expected vectors of one length, got t of 60"):
        recordings_in(folder)


def simulink(*labels: str, **more: Any) -> dict[str, Any]:
    """A structure with time of as many signals as there are labels."""
    signals = [{"values": (k + 1) * POSITION, "dimensions": 1.0, "label": label} for k, label in enumerate(labels)]
    return {"time": T, "signals": signals, **more}


def test_signals_of_simulink_have_their_labels_for_names(folder: Path, write: Any):
    """They were simout.signals_0.values and simout.signals_1.values."""
    write(folder / "a.mat", {"simout": simulink("Moment (Nm)", "Winkel (Grad)", blockName="arm/To Workspace")})
    content, said = made(folder)
    assert [run["file"] for run in content["runs"]] == ["a.csv"]
    assert "Winkel (Grad) is position_0_rad, × 0.0174533" in said
    np.testing.assert_allclose(read_campaign(folder.parent / "made").runs[0].u[:, 0], POSITION)


def test_signals_of_simulink_without_a_label_of_their_own_have_their_numbers(folder: Path, write: Any):
    write(folder / "a.mat", {"simout": simulink("tau", "", "q", "q", "time")})
    (one,) = recordings_in(folder)
    numbered = {f"simout.signals_{k}.values" for k in (1, 2, 3, 4)}
    assert set(one.table.columns) == {"simout.time", "simout.tau"} | numbered
    np.testing.assert_array_equal(one.table.numbers("simout.signals_4.values"), 5 * POSITION)


def test_signals_of_simulink_without_labels_are_as_before(folder: Path, write: Any):
    write(folder / "a.mat", {"simout": simulink("", "")})
    (one,) = recordings_in(folder)
    assert set(one.table.columns) == {"simout.time", "simout.signals_0.values", "simout.signals_1.values"}


def test_a_torque_of_another_length_is_told_where_none_is_found(folder: Path, write: Any):
    write(folder / "a.mat", {"time_s": T, "position_rad": POSITION, "torque_Nm": TORQUE[:-5]})
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder.parent / "made"), "--synthetic", "--yes"])
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert "torque_Nm (55 values); cut them to the same rows where they belong together" in line.replace("…", "")
