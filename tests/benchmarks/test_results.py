"""Every page of results is written from stored JSON, or says in its first line of which version it is."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from benchmarks import front_door, identification_devices, same_results, whole_model
from benchmarks.house import page_of as house_page
from benchmarks.machines.page import page_of as machines_page
from benchmarks.peers import table as time_to_truth
from benchmarks.performance.figures import all_figures
from benchmarks.performance.page import draw_growth, text_table, workers_in_words
from benchmarks.performance.page import page_of as performance_page
from benchmarks.posteriors import effective_samples, scatter_recovery
from benchmarks.search import coupled_missing, lookalikes, search_growth
from benchmarks.simulators import page as simulators
from docs.accessibility import find_browser
from docs.parts.tables import with_parts
from haptid.support.installing.environment import ROOT
from studies.calibration import result as calibration
from studies.thresholds import page as thresholds
from tests.fuzz import run as fuzzing

RESULTS = ROOT / "docs" / "results"


def page_of_time_to_truth(stored: dict[str, Any]) -> str:
    cases = {name: case["contestants"] for name, case in stored["cases"].items()}
    return time_to_truth.page(cases, stored)


WRITTEN: Mapping[str, Callable[[dict[str, Any]], str]] = {
    "calibration": calibration.page,
    "coupled_missing": coupled_missing.page,
    "effective_samples": effective_samples.page,
    "fuzzing": fuzzing.page,
    "house": house_page,
    "identification_devices": identification_devices.page,
    "identification_machines": identification_devices.page,
    "lookalikes": lookalikes.page,
    "performance": performance_page,
    "real_machines": machines_page,
    "search_growth": search_growth.page,
    "same_results": same_results.page_of,
    "scatter_recovery": scatter_recovery.page,
    "thresholds": thresholds.page,
    "time_to_truth": page_of_time_to_truth,
    "whole_model": whole_model.page,
}
TYPED = ("change_exercises",)
"""Pages whose numbers no file holds."""


@pytest.mark.parametrize("name", WRITTEN)
def test_a_page_is_that_of_its_stored_results(name: str):
    stored = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    assert (RESULTS / f"{name}.md").read_text(encoding="utf-8") == WRITTEN[name](stored)


@pytest.mark.parametrize("name", TYPED)
def test_a_typed_page_says_first_of_which_version_it_is(name: str):
    first = (RESULTS / f"{name}.md").read_text(encoding="utf-8").splitlines()[2]
    assert re.search(r"\b[0-9a-f]{7}\b", first)
    assert re.search(r"\b20\d\d-\d\d-\d\d\b", first)
    assert "no file holds" in first


def test_the_pages_on_other_simulators_are_those_of_their_stored_results():
    for path, texts in simulators.parts_by_page().items():
        page = path.read_text(encoding="utf-8")
        assert page == with_parts(page, texts, simulators.SCRIPT)


def test_stored_clients_reproduced_every_column():
    stored = json.loads((RESULTS / "clients.json").read_text(encoding="utf-8"))
    ran = [row for row in stored["rows"] if "largest_difference" in row]
    assert {row["client"] for row in ran} >= {"fmpy", "fmpy_compile", "libcosim", "ecos"}
    for row in stored["rows"]:
        assert row["largest_difference"] <= 1e-9, row
        assert row.get("to_reference_run", 0.0) <= 1e-5, row
    assert stored["problems"] == 0


def test_stored_platforms_gave_the_same_bits():
    stored = json.loads((RESULTS / "platforms.json").read_text(encoding="utf-8"))
    ran = [row for row in stored["rows"] if "sha256" in row]
    assert {row["platform"] for row in ran} == {"x86_64-linux", "aarch64-linux", "x86_64-windows"}
    for fmu in {row["fmu"] for row in ran}:
        assert len({row["sha256"] for row in ran if row["fmu"] == fmu}) == 1  # FMI 2.0 and 3.0 too
    assert max(row["largest_difference"] for row in ran) == 0.0
    archives = stored["archives"]
    assert archives["same_bytes"] == archives["built_twice"] == 9
    assert archives["places"] == []


def test_the_stored_native_fmu_is_as_fast_as_c_by_hand():
    stored = json.loads((RESULTS / "fmu_speed.json").read_text(encoding="utf-8"))
    assert stored["speed_over_by_hand"] >= 0.85


def test_six_stored_foreign_fmus_were_calibrated():
    stored = json.loads((RESULTS / "foreign_fmus.json").read_text(encoding="utf-8"))
    done = [row for row in stored["rows"] if "failed" not in row]
    assert len(done) >= 6
    assert {row["fmi"][0] for row in done} == {"2", "3"}
    for row in done:
        assert row["validate_over_noise"] < 1.4, row
        for one in row["parameters"].values():
            assert abs(one["value"] - one["truth"]) < 4 * one["std"], row


def test_stored_bodies_are_haptids_and_move_as_the_fmu():
    stored = json.loads((RESULTS / "multibody.json").read_text(encoding="utf-8"))
    assert max(max(row["mass_matrix"], row["bias"]) for row in stored["terms"]) <= 1e-9
    worst = {way: max(max(r["rms_over_noise"]) for r in stored["motions"] if r["friction"] == way) for way in
             ("viscous alone", "LuGre", "frictionloss")}  # fmt: skip
    assert worst["viscous alone"] < 1e-3
    assert worst["LuGre"] < 0.5
    assert worst["frictionloss"] > 1  # as the page says: this friction leaves more than the noise


def test_there_is_no_other_page():
    pages = {path.stem for path in RESULTS.glob("*.md") if not path.stem.startswith("blind")}
    assert pages == {*WRITTEN, *TYPED}


def test_the_table_of_performance_has_the_figures_of_all_benchmarks():
    figures = all_figures()
    origins = {one.origin.partition(",")[0] for one in figures}
    assert origins == {
        "performance.json", "from_tables_to_fmu.json", "time_to_truth.json", "real_machines.json", "fmu_speed.json",
        "fuzzing.json", "front_door.json", "install.json",
    }  # fmt: skip
    table = text_table(figures)
    assert all(one.name[:40] in table for one in figures)


def test_the_front_door_states_what_axe_finds_on_a_screen_and_on_a_phone():
    stored = json.loads((RESULTS / "front_door.json").read_text(encoding="utf-8"))
    assert set(stored["axe"]) == {"documentation", "report"}
    assert all(one["violations"] == {"1280": 0, "390": 0} for one in stored["axe"].values())
    assert sum(one.group == "violations that axe-core finds" for one in all_figures()) == 4


@pytest.mark.skipif(find_browser() is None, reason="no Chromium here")
def test_a_page_without_a_language_counts_at_both_widths(tmp_path: Path):
    pytest.importorskip("axe_playwright_python", reason="a dependency of development")
    (tmp_path / "a.html").write_text("<!doctype html><title>a</title><main><h1>a</h1></main>", encoding="utf-8")
    assert front_door.count_violations([tmp_path / "a.html"]) == {"pages": 1, "violations": {"1280": 1, "390": 1}}


def test_every_panel_of_the_growth_has_numbers_at_both_axes_within_the_picture():
    """Axes of less than a power of ten had no number, and a label at the edge was cut."""
    made = draw_growth(json.loads((RESULTS / "performance.json").read_text(encoding="utf-8")))
    made.canvas.draw()
    shown = [axis for axis in made.axes if axis.get_visible()]
    assert len(shown) == 2 * len(json.loads((RESULTS / "performance.json").read_text(encoding="utf-8"))["curves"])
    for axis in shown:
        for one, ends in ((axis.xaxis, sorted(axis.get_xlim())), (axis.yaxis, sorted(axis.get_ylim()))):
            ticks = [
                tick for tick in one.get_major_ticks()
                if tick.label1.get_text() and ends[0] <= tick.get_loc() <= ends[1]
            ]  # fmt: skip
            assert len(ticks) >= 2
            assert min(tick.label1.get_fontsize() for tick in ticks) >= 8
            for text in (*(tick.label1 for tick in ticks), one.label):
                box = text.get_window_extent()
                assert box.width == 0 or (made.bbox.x0 <= box.x0 and box.x1 <= made.bbox.x1)


def test_a_comparison_takes_the_place_of_an_earlier_one_of_the_same_commits(tmp_path: Path):
    stored = tmp_path / "same.json"
    one = {"command": "a", "date": "2026-11-27", "before": "1", "after": "2", "files": {"fits/a.json": "differs"}}
    same_results.keep(stored, one)
    same_results.keep(stored, one | {"files": {"fits/a.json": "same", "plan/b.json": "missing on one side"}})
    page = stored.with_suffix(".md").read_text(encoding="utf-8")
    assert page.count("## Commits 1 and 2") == 1
    assert "1 of 2 files are the same" in page
    assert "| `plan/` | `python -m model.plan` | 1 | 0 | `plan/b.json` (missing on one side) |" in page


@pytest.mark.parametrize(("walls", "said"), [((5.8, 46.0), "no sooner than one"), ((5.8, 3.1), "sooner than one")])
def test_the_words_on_workers_follow_their_numbers(walls: tuple[float, float], said: str):
    points = [{"size": size, "wall_s": wall} for size, wall in zip((1, 2), walls, strict=True)]
    told = workers_in_words({"curves": {"workers": {"points": points}}})
    assert f"Several workers were {said}" in told
    assert f"{walls[0]} s with 1, {walls[1]:.2g} s with 2" in told
    assert workers_in_words({"curves": {}}) == ""
