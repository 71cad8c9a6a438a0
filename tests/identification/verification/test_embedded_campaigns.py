"""What the whole models of the embedded campaigns leave: the aim, by their stored values simulated again."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.whole_model import AIM, MACHINES, extract
from haptid.identification.verification.verify import verify
from haptid.measurement.format.embedded import FOLDERS, embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.model.device.reader import load_device
from haptid.report.identification.campaign_comparison import STORED, comparison_table, worst_by_joint
from haptid.support.installing.environment import ROOT

KEPT = json.loads((ROOT / "docs" / "results" / "whole_model.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", FOLDERS)
def test_stored_values_leave_the_stored_residuals_on_the_unseen_runs(name: str) -> None:
    stored = KEPT["machines"][0]["campaigns"][name]
    campaign = read_campaign(embedded_campaign(name))
    unseen = [run for run in campaign.runs if len(run.free_joints) == 6]
    assert all(run.use == "validate" for run in unseen)
    found = verify(load_device("freedom6s"), stored["values"], unseen, campaign.extra["controller"])
    over = [[joint.rmse_over_noise for joint in run.joints] for run in found.runs]
    np.testing.assert_allclose(over, [run["rmse_over_noise"] for run in stored["runs"]], rtol=0.02)
    closed = np.array([row for row, run in zip(over, found.runs, strict=True) if run.mode == "closed_loop"])
    assert closed.shape == (2, 6)
    assert (closed.max() <= AIM) == (name == "planned")


def test_the_planned_tests_reach_the_aim_on_every_stored_machine() -> None:
    assert len(KEPT["machines"]) >= 3
    for machine, (width, seed) in zip(KEPT["machines"], MACHINES, strict=False):
        assert (machine["variation"], machine["seed"]) == (width, seed)
        planned, paper = (
            max(worst_by_joint(machine["campaigns"][name]["runs"], "closed_loop")) for name in ("planned", "paper")
        )
        assert planned <= AIM < paper


def test_the_report_has_the_stored_results_of_the_embedded_campaigns() -> None:
    assert json.loads(STORED.read_text(encoding="utf-8")) == extract(KEPT)


@pytest.mark.parametrize("name", FOLDERS)
def test_the_report_shows_this_campaign_and_the_stored_other_one(name: str) -> None:
    campaign = read_campaign(embedded_campaign("paper"))
    unseen = [run for run in campaign.runs if len(run.free_joints) == 6][:1]
    found = verify(load_device("freedom6s"), {}, unseen, campaign.extra["controller"])
    table = comparison_table(found, name)
    other = KEPT["machines"][0]["campaigns"]["paper" if name == "planned" else "planned"]["runs"]
    rows = {row[-1]: row[1:-1] for row in table.rows}
    here = [f"{joint.rmse_over_noise:.2f}" for joint in found.runs[0].joints]
    assert list(rows.pop("this page")) == here
    ((source, stored),) = rows.items()
    assert list(stored) == [f"{value:.2f}" for value in worst_by_joint(other, "closed_loop")]
    assert KEPT["date"] in source
