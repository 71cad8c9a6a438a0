"""Posteriors and findings of other data that lie in the folder of an identification are told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from haptid.api.earlier_results import of_other_data

SAME = {(0,): frozenset({"aa"}), (1,): frozenset({"bb", "cc"})}


def laid_out(folder: Path) -> Path:
    entries = [
        {"free_joints": joints, "parameters": {}, "outcome": "converged", "runs": [], "data": digest}
        for joints, digest in (([0], "aa"), ([1], "cc"))
    ]
    content = {
        "schema": "identification/1", "device": "single_joint", "campaign": "a test", "measured": True,
        "configurations": entries, "links": {}, "verification": {"runs": []},
    }  # fmt: skip
    (folder / "identification.json").write_text(json.dumps(content))
    (folder / "discrepancy").mkdir()
    for name in ("joint0", "joint0_gap", "whole"):
        (folder / "discrepancy" / f"{name}.json").write_text("{}")
    (folder / "posterior.json").write_text("{}")
    return folder


def test_results_of_the_same_data_are_no_news(tmp_path: Path):
    assert of_other_data(laid_out(tmp_path), "a test", SAME) == ()
    assert of_other_data(tmp_path, "a test", {(0,): frozenset({"aa"})}) == ()  # one joint alone, identified again


@pytest.mark.parametrize(
    ("title", "digests"),
    [("another", SAME), ("a test", {(0,): frozenset({"dd"})}), ("a test", {**SAME, (1,): frozenset({"bb"})})],
)
def test_results_of_other_data_are_told(tmp_path: Path, title: str, digests: dict[tuple[int, ...], frozenset[str]]):
    found = of_other_data(laid_out(tmp_path), title, digests)
    assert found == ("posterior.json", "discrepancy/joint0.json", "discrepancy/whole.json")


def test_an_empty_folder_holds_nothing(tmp_path: Path):
    assert of_other_data(tmp_path, "a test", SAME) == ()
