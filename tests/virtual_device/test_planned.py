"""Tests in other lock postures: read from the plan, simulated where it says, and fitted each for itself."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.identification.run import main as identify
from haptid.support.errors import InputError
from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.campaign import header
from haptid.virtual_device.recording.planned import PlannedTest, planned_runs, read_planned
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.simulate import simulate_joint
from haptid.virtual_device.recording.tables import write_campaign

POSTURE = (0.4, -0.3, 0.35, 0.0, -0.6, 0.6)
SILENT = Sensor(noise=0.0, resolution=0.0)


def plan(folder: Path, tests: list[dict[str, object]]) -> Path:
    path = folder / "locking_plan.json"
    path.write_text(json.dumps({"postures": {"tests": tests}}))
    return path


def test_plan_is_read(tmp_path: Path) -> None:
    path = plan(tmp_path, [{"free_joints": [0, 1], "locked_positions_rad": list(POSTURE)}])
    assert read_planned(path) == (PlannedTest(free_joints=(0, 1), posture=POSTURE),)


@pytest.mark.parametrize(
    "test", [{"free_joints": [7], "locked_positions_rad": [0.0] * 6}, {"free_joints": [1], "locked_positions_rad": [0]}]
)
def test_plan_of_another_device_is_refused(tmp_path: Path, test: dict[str, object]) -> None:
    with pytest.raises(InputError, match="6 joints"):
        read_planned(plan(tmp_path, [test]))


def test_file_that_is_no_plan_is_refused(tmp_path: Path) -> None:
    for text in ("{}", "not json"):
        (tmp_path / "plan.json").write_text(text)
        with pytest.raises(InputError, match=r"locking_plan\.json"):
            read_planned(tmp_path / "plan.json")


def test_arm_with_one_joint_free_moves_as_that_joint_alone() -> None:
    """The whole arm's equations against those of one joint with the coefficients of the posture."""
    arm = Arm(read_truth())
    first = planned_runs(arm, PlannedTest(free_joints=(3,), posture=POSTURE), 0, sensor=SILENT, seed=1)[0]
    assert first.entry(JOINTS)["locked_positions_rad"] == list(POSTURE)
    parameters = arm.locked_joint(3, np.array(POSTURE))
    t, torque, y = (first.columns[name] for name in ("time_s", "torque_3_Nm", "position_3_rad"))
    alone = simulate_joint({**parameters, "q0": y[0]}, t, torque, sensor=SILENT, period=2 * np.pi, seed=0)
    assert np.ptp(y) > 0.05
    np.testing.assert_allclose(alone, y, atol=2e-7)  # readings are rounded to 1e-7 rad


@pytest.mark.long
def test_each_posture_is_a_configuration_and_coefficients_of_different_postures_are_not_compared(
    tmp_path: Path,
) -> None:
    arm, sensor = Arm(read_truth()), Sensor(noise=2e-4, resolution=1.5e-4)
    tests = [PlannedTest(free_joints=(1,), posture=p) for p in ((0.0,) * 6, POSTURE)]
    runs = [run for k, test in enumerate(tests) for run in planned_runs(arm, test, k, sensor=sensor, seed=2)]
    write_campaign(tmp_path / "c", header("synthetic", "freedom6s", sensor), runs, joints=JOINTS)
    fast = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton", "--starts", "1", "--no-export")
    done = CliRunner().invoke(identify, [str(tmp_path / "c"), "--out", str(tmp_path / "out"), *fast])
    assert done.exit_code == 0, done.output
    assert "joint 1, posture 2" in done.output
    data = json.loads((tmp_path / "out" / "identification.json").read_text())
    assert data["locking_order"] == [[1]]
    home, posed = data["configurations"]
    assert posed["locked_positions_rad"] == [0.4, 0.0, 0.35, 0.0, -0.6, 0.6]
    both = [c["parameters"]["inertia"] for c in (home, posed)]
    assert abs(both[0]["value"] - both[1]["value"]) > 20 * max(one["std"] for one in both)
    truth = arm.locked_joint(1, np.array(POSTURE))["inertia"]
    assert abs(both[1]["value"] - truth) < 4 * both[1]["std"]
    compared = {a["name"]: a["p"] for a in posed["agreement"]}
    assert "joint 1, posture 2: inertia and gravity against earlier tests" in compared
    assert {"Fc", "sigma0"} <= set(compared)
    assert not {"inertia", "gravity_cos", "gravity_sin"} & set(compared)
    assert min(compared.values()) > 1e-4
