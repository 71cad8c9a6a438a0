"""Revisions held against each other: what is run, what is compared, and what the page says of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import same_results
from benchmarks.revisions import merges, pairs, runs
from benchmarks.revisions.cases import CASES, Case
from benchmarks.revisions.differences import (
    better,
    distance_from_truth,
    largest_in_errors,
    largest_of_numbers,
    largest_of_parameters,
    largest_of_unseen,
)
from benchmarks.revisions.results import figures_of
from haptid.support.installing.environment import ROOT

STORED = json.loads((ROOT / "docs" / "results" / "same_results.json").read_text(encoding="utf-8"))
FIT, EMPS = "embedded_identification", "emps_identification"
CASE = next(case for case in CASES if case.name == FIT)


def fit(stiffness: float = 2.0, damping: float = 0.5, seen: float = 0.1, unseen: float = 0.2, **more: Any) -> dict:
    """Return identification.json with what is compared."""
    rows = {
        "Ks": {"value": stiffness, "std": 0.1, "status": "identified"},
        "sigma1": {"value": damping, "std": 0.5, "status": "unidentifiable"},
        "Kp": {"value": 1.0, "std": 0.0, "status": "fixed"},
    }
    scores = [
        {"file": "a.csv", "use": "fit", "rmse_rad": seen},
        {"file": "b.csv", "use": "validate", "rmse_rad": unseen},
    ]
    return {"configurations": [{"parameters": rows, "runs": scores, "cost": 3.0, **more}]}


def search(verdict: str = "named", value: float = 0.02, after: float = 0.004) -> dict[str, Any]:
    """Return discrepancy/joint4.json with what is compared."""
    effects = [{"id": "cogging", "parameters": {"cogging_sin": {"value": value, "std": 0.01}}}]
    return {"verdict": verdict, "effects": effects, "gap": {"validate": {"before": 0.01, "after": after}}}


def held(before: dict[str, Any], after: dict[str, Any], name: str = FIT) -> dict[str, Any]:
    sides = [{"outcome": "done", "wall_s": 1.0, "result": result} for result in (before, after)]
    return pairs.compare_sides(name, *sides)


def test_figures_of_a_fit_are_its_known_parameters_and_the_rms_that_no_fit_saw():
    assert figures_of(fit()) == {"cost": 3.0, "parameters": {"Ks": [2.0, 0.1]}, "unseen": {"b.csv": 0.2}}


def test_the_rms_of_a_scored_torque_is_that_of_the_torque():
    result = fit()
    result["configurations"][0]["runs"][1] |= {"rmse_rad": None, "rmse_Nm": 0.7}
    assert figures_of(result)["unseen"] == {"b.csv": 0.7}


def test_figures_of_a_search_are_verdict_effects_and_what_is_left_on_unseen_rows():
    figures = figures_of(search())
    assert (figures["verdict"], figures["effects"]) == ("named", ["cogging"])
    assert figures["parameters"] == {"cogging_sin": [0.02, 0.01]}
    assert figures["unseen"] == {"unseen rows": 0.004}


def test_the_largest_differences_are_found():
    before, after = figures_of(fit(stiffness=2.0, unseen=0.2)), figures_of(fit(stiffness=1.5, unseen=0.1))
    assert (largest_of_parameters(before, after).difference, largest_of_parameters(before, after).name) == (0.25, "Ks")
    assert largest_in_errors(before, after).difference == pytest.approx(5.0)
    assert largest_of_unseen(before, after).difference == 0.5
    assert largest_of_numbers({"a": [1.0, True, "x"], "b": 3}, {"a": [1.0, False, "y"], "b": 4}).name == "b"


def test_the_truth_counts_where_it_is_known_and_not_zero():
    figures = {"parameters": {"Ks": [1.1, 0.1], "o": [0.2, 0.1], "other": [5.0, 1.0]}}
    assert distance_from_truth(figures, {"Ks": 1.0, "o": 0.0}) == pytest.approx(0.1)
    assert distance_from_truth(figures, {}) is None


@pytest.mark.parametrize(
    ("before", "after", "side"), [(2.0, 1.0, "after"), (1.0, 2.0, "before"), (1.0, 1.0, ""), (None, 1.0, "")]
)
def test_the_smaller_number_is_the_better(before: float | None, after: float, side: str):
    assert better(before, after) == side


def test_equal_results_are_the_same_and_their_figures_are_not_kept():
    outcome = held(fit(), fit())
    assert outcome["same"]
    assert "figures" not in outcome["before"]
    assert merges.result_in_words(outcome) == "embedded campaign, fit of joint 4: the same"


def test_results_that_differ_beside_their_figures_say_where():
    outcome = held(fit(covariance=[1.0, 2.0]), fit(covariance=[1.0, 2.5]))
    assert not outcome["same"]
    assert merges.result_in_words(outcome).endswith(
        "the same parameters and RMS, other numbers by up to 0.2 (`covariance.1`)"
    )


def test_results_that_differ_are_told_by_their_figures():
    words = merges.result_in_words(held(fit(stiffness=2.0), fit(stiffness=1.5, unseen=0.1)))
    assert "parameters by up to 0.25, 5 standard errors" in words
    assert "RMS on unseen runs by up to 0.5" in words


def test_another_verdict_is_told():
    name = "dvrk_mtm_joint4_discrepancy"
    words = merges.result_in_words(held(search(), search("unlisted"), name))
    assert "named (cogging) before, unlisted (cogging) after" in words
    assert "the same verdict and effects" in merges.result_in_words(held(search(), search(value=0.03), name))


def test_a_command_without_result_is_told_and_not_compared():
    before = {"outcome": "stopped after 120 s", "wall_s": 120.0, "result": None}
    after = {"outcome": "not run", "wall_s": 0.0, "result": None}
    outcome = pairs.compare_sides(EMPS, before, after)
    assert not outcome["same"]
    assert merges.result_in_words(outcome) == "EMPS, fit: stopped after 120 s before, not run after"


@pytest.mark.parametrize(
    ("after", "judged"),
    [
        (fit(stiffness=2.2, unseen=0.1), "before (truth), after (unseen)"),
        (fit(stiffness=2.0005, unseen=0.1), "neither: 0.005 standard errors apart"),
    ],
)
def test_the_page_says_which_side_was_right(after: dict[str, Any], judged: str):
    pair = {"before": "1", "after": "2", "packages": [], "cases": [held(fit(stiffness=2.0), after)]}
    assert f"| {judged} |" in merges.differing_table({"pairs": [pair], "truth": {"Ks": 1.9}})


def test_what_was_measured_stands_in_the_place_of_what_was_not_held():
    pair = {"before": "1", "after": "2", "packages": ["tqdm"], "cases": [held(fit(), fit()), held(fit(), fit(), EMPS)]}
    rows = [{"merge": name, "commit": name, "held": "by hand", "real": "not held"} for name in ("2", "3")]
    page = merges.merges_section({"merges": rows, "pairs": [pair], "truth": {}})
    assert "| 2 | 2 | embedded campaign, fit of joint 4: the same; at the time: by hand | EMPS, fit: the same |" in page
    assert "| 3 | 3 | by hand | not held |" in page
    assert "tqdm was installed beside them for 2." in page


def test_cases_that_are_measured_anew_replace_the_earlier_ones_and_leave_the_others(tmp_path: Path):
    stored = tmp_path / "same.json"
    pair = {"before": "1", "after": "2", "date": "2026-11-27", "packages": []}
    same_results.keep_pair(stored, pair | {"cases": [held(fit(), fit(), EMPS), held(fit(), fit(unseen=0.3))]})
    same_results.keep_pair(stored, pair | {"cases": [held(fit(), fit())]})
    (kept,) = json.loads(stored.read_text(encoding="utf-8"))["pairs"]
    assert [(case["case"], case["same"]) for case in kept["cases"]] == [(FIT, True), (EMPS, True)]


def a_revision(folder: Path, program: str) -> Path:
    """Return the folder of a revision whose identification is a program of one line."""
    package = folder / "tree" / "identification"
    package.mkdir(parents=True)
    (package / "run.py").write_text(f"import pathlib, sys, time\n{program}\n", encoding="utf-8")
    return folder


WRITE = "out = pathlib.Path(sys.argv[2]); out.mkdir(parents=True); (out / 'identification.json').write_text('{}')"


@pytest.mark.parametrize(
    ("program", "outcome"),
    [
        (WRITE, "done"),
        ("sys.exit('error: no such joint')", "failed: error: no such joint"),
        ("time.sleep(60)", "stopped after 1 s"),
    ],
)
def test_a_command_of_a_revision_ends_with_a_result_or_with_the_reason_for_none(
    tmp_path: Path, program: str, outcome: str
):
    limited: Case = replace(CASE, limit_s=1.0 if "sleep" in program else 60.0)
    out = runs.run_case(limited, tmp_path, a_revision(tmp_path, program), None)
    assert json.loads((out / runs.OUTCOME).read_text(encoding="utf-8"))["outcome"] == outcome


def test_what_ran_before_is_not_run_again(tmp_path: Path):
    folder = a_revision(tmp_path, WRITE)
    runs.run_case(CASE, tmp_path, folder, None)
    (folder / "tree" / "identification" / "run.py").write_text("raise SystemExit(1)\n", encoding="utf-8")
    out = runs.run_case(CASE, tmp_path, folder, None)
    assert json.loads((out / runs.OUTCOME).read_text(encoding="utf-8"))["outcome"] == "done"


def test_a_package_counts_as_needed_where_the_revision_requires_it(tmp_path: Path):
    (tmp_path / "pyproject.toml").write_text('dependencies = ["tqdm>=4.66"]\n', encoding="utf-8")
    beside = tmp_path / "beside"
    for name in ("tqdm", "rich", "bin"):
        (beside / name).mkdir(parents=True)
    assert pairs.packages_needed(tmp_path, beside) == ["tqdm"]
    assert pairs.packages_needed(tmp_path, None) == []


def test_every_merge_of_one_commit_was_measured_on_the_embedded_campaign_and_on_the_real_sets():
    # The move into rooms is compared file by file above the merges.
    commits = {merge["commit"] for merge in STORED["merges"]} - {"f1874fa1", "not merged", "several"}
    assert {pair["after"] for pair in STORED["pairs"]} == commits
    for pair in STORED["pairs"]:
        assert {FIT, EMPS, "dvrk_mtm_joint4_identification"} <= {case["case"] for case in pair["cases"]}
