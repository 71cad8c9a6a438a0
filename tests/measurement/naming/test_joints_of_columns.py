"""Which joint a column stands for: by the device's own names, or by numbers from 0 or from 1."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from haptid.measurement.format.reading import read_campaign
from haptid.measurement.new import main
from haptid.measurement.values.warning import CampaignWarning

T = np.arange(400) * 0.005


def init(folder: Path, names: tuple[str, str, str, str], **more: object) -> Result:
    """Make a campaign of an arm's log whose columns of torques and angles in degrees have these names."""
    tables = folder / "tables"
    tables.mkdir()
    values = (np.cos(3 * T), 0.5 * np.cos(3 * T + 1), 20 * np.sin(3 * T), 30 + 10 * np.sin(3 * T + 1))
    frame = pd.DataFrame({"time_s": T, **dict(zip(names, values, strict=True)), **more})
    frame.to_csv(tables / "log.csv", index=False)
    arguments = [str(tables), "--device", "double_pendulum", "--measured", "--out", str(folder / "made"), "--yes"]
    return CliRunner().invoke(main, arguments)


@pytest.mark.parametrize(
    "names",
    [
        ("shoulder_torque_Nm", "elbow_torque_Nm", "shoulder_pos_deg", "elbow_pos_deg"),
        ("Shoulder torque [Nm]", "Elbow torque [Nm]", "Shoulder angle [deg]", "Elbow angle [deg]"),
        ("tau1 [Nm]", "tau2 [Nm]", "q1 [deg]", "q2 [deg]"),
        ("torque_0_Nm", "torque_1_Nm", "position_0_deg", "position_1_deg"),
    ],
)
def test_columns_of_the_devices_joints_are_understood(tmp_path: Path, names: tuple[str, str, str, str]):
    """The URDF's own names made a campaign of one joint; a temperature without a number, joints 1 and 2."""
    made = init(tmp_path, names, temp_C=31.0)
    assert made.exit_code == 0, made.output
    (run, *_) = read_campaign(tmp_path / "made").runs
    assert run.free_joints == (0, 1)
    np.testing.assert_allclose(np.ptp(run.y, axis=0), np.radians([40.0, 20.0]), rtol=0.02)
    assert np.ptp(run.u[:, 0]) == pytest.approx(2.0, rel=0.01)


def test_a_part_of_a_word_is_no_joint(tmp_path: Path):
    made = init(tmp_path, ("shoulder_torque_Nm", "elbows_torque_Nm", "shoulder_pos_deg", "elbows_pos_deg"))
    assert made.exit_code == 0, made.output
    assert "elbows_torque_Nm is" not in made.output
    with pytest.warns(CampaignWarning, match="kept and not used: elbows_torque_Nm, elbows_pos_deg"):
        campaign = read_campaign(tmp_path / "made")
    assert campaign.runs[0].free_joints == (0,)


def test_a_joint_that_the_device_lacks_is_named_with_its_factor(tmp_path: Path):
    made = init(tmp_path, ("torque_0_Nm", "tau3 [Nm]", "position_0_deg", "q3 [deg]"))
    assert made.exit_code == 2
    assert f"--map 'q3 [deg]=position_1_rad*{math.radians(1):.6g}'" in made.output


def test_the_angle_of_a_count_may_be_a_product_as_the_dialogue_takes_it(tmp_path: Path):
    tables = tmp_path / "tables"
    tables.mkdir()
    counts = np.round(3000 * np.sin(3 * T)).astype(int)
    frame = pd.DataFrame({"time_s": T, "torque (Nm)": np.cos(3 * T), "encoder counts": counts})
    frame.to_csv(tables / "log.csv", index=False)
    arguments = [str(tables), "--measured", "--out", str(tmp_path / "made"), "--resolution", "2pi/16384"]
    made = CliRunner().invoke(main, arguments)
    assert made.exit_code == 0, made.output
    (run, *_) = read_campaign(tmp_path / "made").runs
    assert run.resolution[0] == pytest.approx(2 * math.pi / 16384, rel=1e-6)
    assert np.ptp(run.y) == pytest.approx(6000 * 2 * math.pi / 16384, rel=0.01)
    refused = CliRunner().invoke(main, [*arguments[:-1], "a count"])
    assert refused.exit_code == 2
    assert "'a count' is not a valid float" in refused.output


def test_joints_that_move_together_ask_for_a_device_in_the_users_words(tmp_path: Path):
    """The error named a line of a campaign.toml that the user does not have."""
    tables = tmp_path / "tables"
    tables.mkdir()
    columns = {"torque_0_Nm": np.cos(3 * T), "torque_1_Nm": np.cos(2 * T), "position_0_rad": np.sin(3 * T)}
    pd.DataFrame({"time_s": T, **columns, "position_1_rad": np.sin(2 * T)}).to_csv(tables / "log.csv", index=False)
    refused = CliRunner().invoke(main, [str(tables), "--out", str(tmp_path / "made"), "--yes"])
    assert refused.exit_code == 2
    assert "log.csv: expected one joint that moves, or a device, got joints 0, 1 that move together" in refused.stderr
    assert "--device says how they are linked" in refused.stderr
    alone = CliRunner().invoke(main, [str(tables), "--out", str(tmp_path / "made"), "--yes", "--free", "1"])
    assert alone.exit_code == 0, alone.output
