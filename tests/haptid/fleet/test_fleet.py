"""``haptid fleet``: who deviates, and that one bad campaign stops nothing."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from haptid.fleet.campaigns import campaigns_in
from haptid.fleet.comparison import Comparison, compare, largest_z_by_chance
from haptid.fleet.result import Identified, device_json
from haptid.support.errors import InputError
from haptid.support.installing.environment import ROOT
from tests.identification.bench_joint import OFF, TRUE, runs

IDS = tuple(f"p{k}" for k in range(8))


def result(values: np.ndarray, std: float = 0.1, status: str = "identified") -> dict[str, object]:
    """Return what compare reads of an identification.json with one joint."""
    parameters = {
        id: {"value": value, "std": std, "unit": "N m", "status": status}
        for id, value in zip(IDS, values.tolist(), strict=False)
    }
    return {"configurations": [{"free_joints": [4], "locked_positions_rad": [], "parameters": parameters}]}


def fleet(rng: np.random.Generator, devices: int) -> dict[str, dict[str, object]]:
    return {f"arm{k}": result(10 + rng.standard_normal(len(IDS))) for k in range(devices)}


def deviating(comparisons: tuple[Comparison, ...]) -> list[tuple[str, str]]:
    return [(member.device, one.parameter) for one in comparisons for member in one.members if member.deviates]


@pytest.mark.parametrize("devices", [4, 6, 12])
def test_equal_devices_are_told_apart_in_at_most_one_fleet_of_twenty(devices: int):
    rng = np.random.default_rng(1)
    fleets = 300
    alarms = sum(bool(deviating(compare(fleet(rng, devices)))) for _ in range(fleets))
    assert alarms / fleets < 0.05 + 3 * np.sqrt(0.05 * 0.95 / fleets)


def test_a_device_far_away_is_named_and_no_other():
    results = fleet(np.random.default_rng(2), 8)
    results["arm3"]["configurations"][0]["parameters"]["p2"]["value"] = 40.0
    assert deviating(compare(results)) == [("arm3", "p2")]


def test_what_is_not_identified_is_shown_and_not_judged():
    results = fleet(np.random.default_rng(2), 8)
    results["arm3"] = result(np.full(len(IDS), 1e3), status="at_bound")
    assert deviating(compare(results)) == []
    assert compare(results)[0].members[3].value == 1e3


def test_calibrated_fmus_are_compared_by_the_names_of_their_variables():
    results = {
        f"arm{k}": {"configurations": [{"parameters": {"mu": {"value": 1.0 + k, "std": 0.1, "status": "identified"}}}]}
        for k in range(5)
    }
    (comparison,) = compare(results)
    assert (comparison.configuration, comparison.parameter, comparison.median) == ("model", "mu", 3.0)
    one = Identified(name="arm0", campaign=Path("a"), folder=Path("b"), error="", kept=False, wall_s=1.0)
    runs = [{"use": "validate", "rmse_over_noise": {"x": 1.5, "v": None}}]
    told = device_json(one, {"measured": True, "configurations": [{"runs": runs}]})
    assert told["worst_over_noise"] == 1.5


def test_three_devices_are_too_few_to_judge():
    comparisons = compare(fleet(np.random.default_rng(3), 3))
    assert all(one.limit is None for one in comparisons)


def test_few_devices_have_a_wide_limit():
    assert largest_z_by_chance(4, 8) > 2 * largest_z_by_chance(12, 8) > 7


def test_campaigns_are_found_and_named(tmp_path: Path):
    for name in ("b", "a"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "campaign.toml").touch()
    assert list(campaigns_in([tmp_path])) == ["a", "b"]
    assert list(campaigns_in([tmp_path / "b"])) == ["b"]
    with pytest.raises(InputError, match="names of their own"):
        campaigns_in([tmp_path, tmp_path / "a"])
    with pytest.raises(InputError, match="expected a campaign or a folder of campaigns, got none"):
        campaigns_in([tmp_path / "a", ROOT / "tests" / "haptid" / "fleet"])


def write_device(folder: Path) -> None:
    """Write a campaign of one joint on a bench."""
    folder.mkdir()
    lines = ['[campaign]\ntitle = "Bench"\ndevice = "single_joint"\nmeasured = false', "[joint.4.parameters]"]
    lines += [f"{id} = {{ initial = {TRUE[id] * factor} }}" for id, factor in OFF.items()]
    for number, run in enumerate(runs()):
        name = f"run{number}.csv"
        frame = {"time_s": run.t, "torque_4_Nm": run.u[:, 0], "position_4_rad": run.y[:, 0]}
        pd.DataFrame(frame).to_csv(folder / name, index=False)
        lines.append(f'[[runs]]\nfile = "{name}"\nfree_joints = [4]\nuse = "{run.use}"')
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")


def run_fleet(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "haptid", "fleet", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.long
def test_a_failing_campaign_stops_nothing_and_the_rest_is_kept(tmp_path: Path):
    folder, out = tmp_path / "campaigns", tmp_path / "out"
    folder.mkdir()
    write_device(folder / "good")
    (folder / "bad").mkdir()
    (folder / "bad" / "campaign.toml").write_text("no toml")
    first = run_fleet(folder, "--out", out, "--json")
    assert first.returncode == 1, first.stderr
    told = json.loads(first.stdout)
    assert [(d["name"], d["outcome"], d["kept"]) for d in told["devices"]] == [
        ("bad", "failed", False),
        ("good", "identified", False),
    ]
    assert "campaign.toml" in told["devices"][0]["error"]
    assert "1 of 2 devices were not identified: bad" in first.stderr
    assert told == json.loads((out / "fleet.json").read_text(encoding="utf-8"))
    with (out / "fleet.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    inertia = next(row for row in rows if row["parameter"] == "inertia")
    assert float(inertia["lower_95"]) < float(inertia["value"]) < float(inertia["upper_95"])
    assert "SYNTHETIC DATA" in (out / "fleet.html").read_text(encoding="utf-8")

    again = json.loads(run_fleet(folder, "--out", out, "--json").stdout)
    assert [d["kept"] for d in again["devices"]] == [False, True]
    assert again["parameters"] == told["parameters"]
