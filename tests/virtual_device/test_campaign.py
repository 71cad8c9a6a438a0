"""Campaigns of the virtual device: whole, labelled, repeatable, and the committed one as its command makes it."""

import gzip
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.model.device.reader import load_device
from haptid.model.planning.lock_postures import plan_postures
from haptid.model.planning.locking_order import locking_order
from haptid.virtual_device.make_campaign import EMBEDDED, PLAN, PLANNED, main
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import AMPLITUDE, rich, table3
from haptid.virtual_device.recording.planned import RUNS, read_planned

JOINT = {
    "inertia": 1.2e-4, "Ks": 0.02, "epos": -0.05,
    "sigma0": 0.6, "sigma1": 0.003, "sigma2": 0.0015, "vs": 0.06, "Fs": 1.4e-3, "Fc": 1.1e-3,
}  # fmt: skip


def made(*arguments: str) -> str:
    result = CliRunner().invoke(main, ["--quiet", *arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize("folder", [EMBEDDED, PLANNED])
def test_embedded_campaign_has_the_runs_that_every_stage_needs(folder: Path) -> None:
    content = tomllib.loads((folder / "campaign.toml").read_text())
    assert content["campaign"]["measured"] is False
    assert "synthetic" in content["campaign"]["title"]
    uses = Counter((tuple(run["free_joints"]), run["use"]) for run in content["runs"])
    for joint in range(6):
        assert uses[(joint,), "fit"] >= 3
        assert uses[(joint,), "validate"] >= 1
    assert uses[(0, 1), "fit"] >= 2
    assert uses[(0, 1), "validate"] >= 1
    assert uses[tuple(range(6)), "validate"] >= 1
    assert {run["file"] for run in content["runs"]} == {path.name for path in folder.glob("*.csv.gz")}
    assert sum(path.stat().st_size for path in folder.iterdir()) < 5e6
    assert all(run["reason"] for run in content["runs"] if run["use"] == "excluded")


def test_the_planned_campaign_has_the_postures_that_the_plan_proposes() -> None:
    device, tests = load_device("freedom6s"), read_planned(PLAN)
    proposed = plan_postures(device, [stage.free for stage in locking_order(device).stages], extra=len(tests))
    expected = [(test.dynamics.joints, pytest.approx(test.dynamics.posture, abs=1e-9)) for test in proposed.chosen]
    assert [(test.free_joints, test.posture) for test in tests] == expected
    content = tomllib.loads((PLANNED / "campaign.toml").read_text())
    planned = [run for run in content["runs"] if any(run["locked_positions_rad"])]
    told = [(tuple(run["free_joints"]), tuple(run["locked_positions_rad"])) for run in planned]
    assert told == [(test.free_joints, test.posture) for test in tests for _ in RUNS]


def test_embedded_campaign_is_what_its_command_makes(tmp_path: Path) -> None:
    """A reading may sit on the edge between two encoder steps, and libraries of exp differ in the last bit."""
    made("--out", str(tmp_path), "--joints", "0,4")
    for path in sorted(tmp_path.glob("*.csv.gz")):
        fresh, stored = pd.read_csv(path), pd.read_csv(EMBEDDED / path.name)
        assert list(fresh.columns) == list(stored.columns)
        differing = np.abs(fresh.to_numpy() - stored.to_numpy()).max(axis=1)
        assert differing.max() < 2e-4
        assert np.mean(differing > 0) < 1e-3


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    for folder, seed in (("a", "5"), ("b", "5"), ("c", "6")):
        made("--out", str(tmp_path / folder), "--joints", "4", "--seed", seed, "--device-variation", "0.3")
    first, again, other = (
        {path.name: path.read_bytes() for path in sorted((tmp_path / name).iterdir())} for name in "abc"
    )
    assert first == again
    assert all(first[name] != other[name] for name in first if name.endswith("gz"))


def test_torque_in_the_table_is_the_torque_that_was_simulated(tmp_path: Path) -> None:
    run = table3(4)[0]
    make_joint_campaign(tmp_path, 4, JOINT, [run], seed=1)
    (path,) = tmp_path.glob("*.csv.gz")
    table = pd.read_csv(path)
    np.testing.assert_array_equal(table["torque_4_Nm"], run.torque())
    np.testing.assert_array_equal(table["time_s"], run.times())
    assert gzip.decompress(path.read_bytes()).startswith(b"time_s,torque_4_Nm,position_4_rad\n")


def test_inputs_are_those_of_the_paper() -> None:
    frequencies = [[run.frequency for run in table3(joint)] for joint in range(6)]
    assert frequencies == [
        [1.0, 1.33, 1.65, 1.975, 2.3], [1.0, 1.21, 1.42, 1.62, 1.83], [1.0, 1.5, 2.0, 2.3, 2.5],
        [0.5, 0.88, 1.25, 1.63, 2.0], [0.5, 1.13, 1.75, 2.38, 3.0], [0.5, 1.0, 1.5, 2.0, 2.5],
    ]  # fmt: skip
    assert AMPLITUDE == (0.020, 0.015, 0.020, 0.008, 0.005, 0.008)
    chosen = rich(3)
    assert len({(run.amplitude, run.frequency) for run in chosen}) == len(chosen)
    assert Counter(run.use for run in chosen) == {"fit": 8, "validate": 3}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--joints", "7"], "--joints: expected joints 0 to 5, got 7"),
        (["--effects", "coging=1", "--joints", "4"], "effects: expected a known effect, got 'coging'; did you mean"),
        (["--effects", "cogging", "--joints", "4"], "expected id=size"),
    ],
)
def test_bad_input_ends_with_one_line_and_code_2(tmp_path: Path, arguments: list[str], says: str) -> None:
    result = CliRunner().invoke(main, ["--quiet", "--out", str(tmp_path / "new"), *arguments])
    assert result.exit_code == 2
    assert says in result.output
    assert not (tmp_path / "new").exists()
