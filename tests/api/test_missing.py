"""The table of a finding: named effects and gaps in one, for each kind of finding."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from haptid.api.missing import Missing
from haptid.api.place import Place

SPRING = {
    "id": "cubic_spring",
    "parameters": {"k3": {"value": 0.03, "std": 0.001, "unit": "N m/rad^3"}},
    "evidence": 412.0,
    "stability": 1.0,
}
GAP = {"before": 2.1e-2, "after": 2.1e-4, "noise": 2e-4, "closed": 0.999}


def finding(folder: Path, **data: Any) -> Missing:
    common = {"joint": 3, "sentence": "In words.", "effects": [], "gap": {}, "gap_unit": "rad", **data}
    return Missing(finding=None, data=common, name="joint3", title="joint 3", place=Place.existing(folder), values=None)


def test_summary_has_the_effects_and_the_gap(tmp_path: Path) -> None:
    table = finding(
        tmp_path, verdict="named", effects=[SPRING], gap={"validate": GAP, "sealed": None, "fit": GAP}
    ).summary()
    assert list(table.columns) == ["value", "std", "unit", "evidence", "stability"]
    assert table.loc[("cubic_spring", "k3")].tolist() == [0.03, 0.001, "N m/rad^3", 412.0, 1.0]
    assert table.loc[("gap of validate", "before"), "value"] == GAP["before"]
    assert table.loc[("gap of fit", "after"), ["value", "unit"]].tolist() == [GAP["after"], "rad"]
    assert len(table) == 5
    assert table.attrs == {"verdict": "named", "sentence": "In words."}


def test_a_stand_in_is_no_named_effect_of_the_summary(tmp_path: Path) -> None:
    gap = {"validate": GAP, "sealed": None, "fit": GAP}
    table = finding(tmp_path, verdict="unlisted", effects=[SPRING], gap=gap).summary()
    assert set(table.index.get_level_values("effect")) == {"stand-in: cubic_spring", "gap of validate", "gap of fit"}


def test_summary_without_effects_has_the_gap(tmp_path: Path) -> None:
    table = finding(tmp_path, verdict="nothing_missing", gap={"validate": GAP, "sealed": None, "fit": GAP}).summary()
    assert table.index.tolist()[:2] == [("gap of validate", "before"), ("gap of validate", "after")]
    assert table["value"].dtype == float


def test_summary_of_the_whole_device_is_by_run_and_joint(tmp_path: Path) -> None:
    row = {"file": "all.csv", "mode": "open loop", "joint": 1, "prismatic": True, "before": 2e-3, "after": 1e-3}
    table = finding(tmp_path, verdict="unlisted", gap={"validate": [row], "fit": None}).summary()
    assert table.loc[("gap of all.csv, open loop, joint 1", "after"), ["value", "unit"]].tolist() == [1e-3, "m"]
