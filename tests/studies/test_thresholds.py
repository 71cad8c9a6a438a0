"""The study of thresholds: a change reaches its readers and goes again, runs are kept, and the page says the JSON."""

from __future__ import annotations

import json
import multiprocessing
import re
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner

from haptid.measurement.checks.preparation import campaign_for_command
from haptid.noise.thresholds import THRESHOLDS as NOISE
from haptid.support.errors import InputError, NumericalError
from haptid.support.installing.environment import ROOT
from studies.thresholds import run
from studies.thresholds.change import change_threshold, noted_reads
from studies.thresholds.one_run import Run, run_apart
from studies.thresholds.outcome import cost_ratio, differences
from studies.thresholds.page import counts, headline, page
from studies.thresholds.panel import PANEL, Case
from studies.thresholds.run import Study
from studies.thresholds.values import ROOMS, all_thresholds, room_values, scale

STAND_IN = "tests.studies.stand_in"
STORED = ROOT / "docs" / "results" / "thresholds.json"
OUTCOME = {
    "verdict": "named", "names": ["cogging"], "closed": 0.99, "times_noise": 1.0, "simulations": 100,
    "values": {"a": [1.0, 0.1]},
}  # fmt: skip


def case(name: str = "quick", work: str = "work") -> Case:
    return Case(name=name, words="nothing", make=f"{STAND_IN}:make", work=f"{STAND_IN}:{work}")


def study(folder: Path, **more: object) -> Study:
    return Study(out=folder / "thresholds.json", campaigns=folder / "campaigns", panel=(case(),), **more)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Study:
    one = study(tmp_path_factory.mktemp("study"))
    one.begin()
    one.deliver()
    one.change()
    return one


def test_every_threshold_of_every_room_is_there_with_what_it_is():
    known = all_thresholds()
    assert {t.room for t in known} == set(ROOMS)
    assert len({t.key for t in known}) == len(known)
    assert all(t.meaning != t.name for t in known)
    modules = {p.parent.name if p.parent.name != "thresholds" else p.parts[-3] for p in _modules()}
    assert modules == {room.partition(".")[0] for room in ROOMS}


def _modules() -> list[Path]:
    return [*ROOT.glob("*/thresholds/thresholds.py"), *ROOT.glob("*/thresholds.py")]


def test_a_share_stays_below_one_and_a_count_above_zero():
    assert scale(0.3, 2.0, is_share=True) == 0.6
    assert scale(0.9, 2.0, is_share=True) == pytest.approx(0.95)
    assert scale(1.05, 2.0, is_share=True) == 2.1
    assert scale(1, 0.5) == 1
    assert scale(((1.0, 0.0), (4, 2.0)), 0.5) == ((0.5, 0.0), (2, 1.0))
    for threshold in all_thresholds():
        for change in ("halved", "doubled"):
            new = threshold.scale_value(change)
            assert new is None or type(new) is type(threshold.value)


def test_a_change_reaches_the_reader_and_is_restored():
    before = NOISE.most_lines
    with change_threshold("noise", "most_lines", 9):
        assert NOISE.most_lines == 9
    assert NOISE.most_lines == before
    with pytest.raises(InputError, match="most_linez"), change_threshold("noise", "most_linez", 9):
        pass


def test_reads_are_noted_for_a_while():
    with noted_reads() as reads:
        assert NOISE.most_lines > 0
        assert room_values("discrepancy.fit").starts_that_agree > 0
    assert NOISE.largest_scatter > 0
    assert reads == {"noise.most_lines", "discrepancy.fit.starts_that_agree"}


def test_a_change_reaches_what_a_module_takes_over_as_it_loads(tmp_path):
    # `PLACES` of the splines is made from a threshold when its module is loaded.
    told = [
        run_apart(Run(case=case(work="count_places"), campaign=tmp_path, **change), 60.0)
        for change in ({}, {"room": "discrepancy.unnamed", "name": "spline_intervals", "value": 14})
    ]
    assert told[1]["simulations"] - told[0]["simulations"] == 7


def test_a_run_that_raises_hangs_or_dies_is_told(tmp_path):
    told = {
        name: run_apart(Run(case=case(work=name), campaign=tmp_path), limit)["failed"]
        for name, limit in (("raises", 60.0), ("hangs", 1.0), ("dies", 60.0))
    }
    assert "ZeroDivisionError" in told["raises"]
    assert told["hangs"] == "not finished within 1 s"
    assert told["dies"] == "the process ended without a result"


def test_only_thresholds_that_a_case_reads_are_changed(finished: Study):
    stored = json.loads(finished.out.read_text(encoding="utf-8"))
    assert stored["delivered"]["quick"]["read"] == ["noise.least_line_over_spectrum", "noise.most_lines"]
    assert set(stored["changes"]) == {"noise.least_line_over_spectrum", "noise.most_lines"}
    lines = stored["changes"]["noise.most_lines"]
    assert lines["halved"]["quick"]["differences"] == ["few → none", "without lines"]
    assert lines["doubled"]["quick"]["differences"] == []
    assert lines["doubled"]["quick"]["cost"] == pytest.approx(2.0)
    n = counts(stored)
    assert (n["read"], n["changing"], n["costing"], n["steady"], n["open"]) == (2, 1, 0, 1, 0)
    assert (n["runs"], n["planned"]) == (4, stored["planned"])


def test_what_is_finished_is_not_run_again(finished: Study, tmp_path, monkeypatch):
    stored = json.loads(finished.out.read_text(encoding="utf-8"))
    del stored["changes"]["noise.most_lines"]["halved"]
    again = study(tmp_path)
    again.out.write_text(json.dumps(stored), encoding="utf-8")
    made = []
    monkeypatch.setattr(run, "run_apart", lambda one, limit: made.append(one.name) or run_apart(one, limit))
    again.begin()
    again.deliver()
    again.change("noise")
    assert made == ["most_lines"]
    assert again.stored["changes"]["noise.most_lines"]["halved"]["quick"]["differences"] == [
        "few → none",
        "without lines",
    ]


def test_no_run_begins_after_the_time(finished: Study, tmp_path):
    stored = json.loads(finished.out.read_text(encoding="utf-8")) | {"changes": {}}
    again = study(tmp_path, minutes=0.0)
    again.out.write_text(json.dumps(stored), encoding="utf-8")
    again.begin()
    again.change()
    assert again.stored["changes"] == {}
    assert "0 of 4 runs" in headline(again.stored)


def test_an_interrupted_study_leaves_no_run_behind(finished: Study, tmp_path, monkeypatch):
    stored = json.loads(finished.out.read_text(encoding="utf-8")) | {"changes": {}}
    again = study(tmp_path)
    again.out.write_text(json.dumps(stored), encoding="utf-8")
    again.begin()

    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "wait", interrupt)
    with pytest.raises(KeyboardInterrupt):
        again.change()
    assert again.stored["changes"] == {}
    assert not multiprocessing.active_children()


def test_a_study_of_other_code_is_not_continued(finished: Study, tmp_path):
    other = study(tmp_path)
    stored = json.loads(finished.out.read_text(encoding="utf-8")) | {"code": "0"}
    other.out.write_text(json.dumps(stored), encoding="utf-8")
    with pytest.raises(InputError, match="same code"):
        other.begin()


def test_a_case_without_an_outcome_is_no_case(tmp_path):
    one = Study(out=tmp_path / "t.json", campaigns=tmp_path, panel=(case(work="raises"),))
    one.begin()
    with pytest.raises(NumericalError, match="'quick' as delivered"):
        one.deliver()


def test_an_unknown_room_is_refused_in_one_line():
    done = CliRunner().invoke(run.main, ["--only", "kitchen"])
    assert done.exit_code == 2
    assert "--only" in done.output
    assert len(done.output.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({}, []),
        ({"verdict": "unlisted"}, ["named → unlisted"]),
        ({"names": ["drag"]}, ["without cogging, with drag"]),
        ({"closed": 0.985}, []),
        ({"closed": 0.9}, ["closed share 0.99 → 0.9"]),
        ({"closed": None}, ["closed share 0.99 → none"]),
        ({"times_noise": 1.2}, ["times the noise 1 → 1.2"]),
        ({"values": {"a": [1.05, 0.1]}}, []),
        ({"values": {"a": [1.25, 0.1]}}, ["a by 2.5 standard errors"]),
        ({"simulations": 300}, []),
        ({"failed": "no start"}, ["no result: no start"]),
    ],
)
def test_what_differs_is_told(change, told):
    assert differences(OUTCOME, OUTCOME | change) == told


def test_simulations_are_a_cost():
    assert cost_ratio(OUTCOME, OUTCOME | {"simulations": 105}) is None
    assert cost_ratio(OUTCOME, OUTCOME | {"simulations": 300}) == 3.0
    assert cost_ratio(OUTCOME, {"failed": "no start"}) is None


@pytest.mark.parametrize("name", ["clean", "driven"])
def test_campaigns_of_the_panel_can_be_read(name, tmp_path):
    (one,) = [each for each in PANEL if each.name == name]
    module, _, function = one.make.partition(":")
    getattr(import_module(module), function)(tmp_path, **one.hidden)
    campaign = campaign_for_command(str(tmp_path))
    assert len(campaign.joints) == 1
    assert {each.use for each in campaign.runs} == {"fit", "validate"}


def test_seeds_of_the_panel_are_those_of_no_stored_study():
    texts = [p.read_text(encoding="utf-8") for p in (ROOT / "docs" / "results").glob("blind/*.json")]
    stored = {int(n) for text in texts for n in re.findall(r'"seed": (\d+)', text)}
    assert stored
    assert not {one.hidden["seed"] for one in PANEL} & stored


def test_numbers_of_the_page_are_those_of_the_json(finished: Study):
    text = finished.out.with_suffix(".md").read_text(encoding="utf-8")
    assert text == page(finished.stored)
    assert headline(finished.stored) in text
    assert "*quick*: **few → none**, **without lines**" in text


@pytest.mark.skipif(not STORED.exists(), reason="no stored study")
def test_the_stored_page_is_made_from_the_stored_json():
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    assert STORED.with_suffix(".md").read_text(encoding="utf-8") == page(stored)
