"""Stages called alone: each says what it found, and leaves a picture."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from matplotlib.image import imread

from haptid.discrepancy.detect.localise import AXES
from haptid.discrepancy.run import main
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import INPUTS, TRUTH

KNOWN = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """One in which a bent spring is hidden, and one in which nothing is."""
    made = {}
    for name, effects in (("bent", {"cubic_spring": {"spring_cubic": 2e-2}}), ("clean", {})):
        made[name] = tmp_path_factory.mktemp(name)
        make_joint_campaign(made[name], 3, TRUTH, INPUTS, effects=effects, sensor=Sensor(), known=KNOWN, seed=5)
    return made


def run(folder: Path, stage: str, out: Path) -> tuple[dict, str]:
    arguments = [str(folder), "--joint", "3", "--stage", stage, "--starts", "2", "--out", str(out), "--quiet"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    made = out / "discrepancy" / f"joint3_{stage}"
    height, width, _ = imread(made.with_suffix(".png")).shape
    assert min(height, width) > 100
    assert {p.name for p in made.parent.iterdir()} >= {f"joint3_{stage}.json", f"joint3_{stage}.png"}
    return json.loads(made.with_suffix(".json").read_text()), result.stdout


@pytest.mark.long
def test_a_gap_is_seen_placed_and_looks_like_what_is_hidden(campaigns: dict[str, Path], tmp_path: Path):
    gap, told = run(campaigns["bent"], "gap", tmp_path)
    assert gap["gap"]
    assert gap["sentence"] in told
    assert "It repeats with the drive." in told
    where, told = run(campaigns["bent"], "where", tmp_path)
    assert where["where"][0]["share_of_gap"] >= 0.5
    assert {r["variable"] for r in where["where"]} == set(AXES)
    assert "% of the gap lies at a" in told
    what, told = run(campaigns["bent"], "what", tmp_path)
    assert what["scores"][0]["p"] < 1e-6
    assert what["scores"][0]["p_sign_flips"] < 0.01
    assert "cubic_spring" in {s["id"] for s in what["scores"][:3]}
    assert "cubic_spring" in told
    assert not (tmp_path / "fmu").exists()


def test_without_a_gap_no_place_and_no_entry_is_told(campaigns: dict[str, Path], tmp_path: Path):
    gap, told = run(campaigns["clean"], "gap", tmp_path)
    assert not gap["gap"]
    assert told.startswith("joint 3: No gap is seen")
    where, told = run(campaigns["clean"], "where", tmp_path)
    assert where["where"] == []
    assert told.startswith("joint 3: No gap is seen")
    what, told = run(campaigns["clean"], "what", tmp_path)
    assert "No effect of the catalogue looks like what is left." in told
    assert what["scores"]
