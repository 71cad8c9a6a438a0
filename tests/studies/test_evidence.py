"""Pages and README of the blind studies say what the stored JSON holds, and pools take every study."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from typing import Any, get_args

import pytest
from click.testing import CliRunner

from docs.parts.tables import with_parts
from haptid.support.errors import InputError
from studies.blind.outcome import RIGHT, Result
from studies.evidence.enter import main as enter
from studies.evidence.pages import pages, readme_text
from studies.evidence.pools import KINDS, RULE, VERDICTS, Study, kind_of, read_studies, verdict_rates
from studies.evidence.run import PART, README, SCRIPT
from studies.ledger.entries import LEDGER, RESULTS, STRANGER, read_ledger

STUDIES = read_studies()
PAGES = pages(STUDIES)
STORED = [json.loads(path.read_text(encoding="utf-8")) for path in sorted((LEDGER.parent / RESULTS).glob("*.json"))]
OWN = [one for one in STORED if one["asked"].get("truth", "own") == "own"]


def test_the_pages_are_those_of_the_stored_studies():
    # A page beside a JSON of its name is that of one study, made by `studies.blind.page`.
    there = {path.name for path in LEDGER.parent.glob("blind*.md") if not path.with_suffix(".json").exists()}
    assert there == set(PAGES), "run python -m studies.evidence.run"
    for name, text in PAGES.items():
        assert (LEDGER.parent / name).read_text(encoding="utf-8") == text, "run python -m studies.evidence.run"
        assert RULE in text


def test_readme_says_what_the_stored_studies_hold():
    text = README.read_text(encoding="utf-8")
    assert text == with_parts(text, {PART: readme_text(STUDIES)}, SCRIPT), "run python -m studies.evidence.run"
    assert len(readme_text(STUDIES).splitlines()) <= 5


def test_numbers_of_readme_are_counted_from_the_files_alone():
    """Counted here a second time, from the JSON and not from the pools."""
    told = readme_text(STUDIES)
    cases = [case for one in OWN for case in one["cases"]]
    left_out = [case for one in OWN for case in one["leave_one_out_cases"]]
    listed = [case for case in cases if case.get("truth") and case["kind"] != "unlisted"]
    for test, group in (
        (lambda case: case["result"] == "named", listed),
        (lambda case: case["result"] == "among_alternatives", listed),
        (lambda case: case["result"] == "false_alarm", [case for case in cases if case["kind"] == "none"]),
        (lambda case: case["verdict"] in ("unlisted", "ambiguous"), left_out),
        (lambda case: case["verdict"] == "named", left_out),
        (lambda told: told["inside"], [told for case in cases for told in case.get("parameters", ())]),
    ):
        assert f"{sum(map(test, group))} of {len(group)} (" in told
    assert re.findall(r"(\d+) in \[the ledger\]", told) == [
        str(sum(entry["truth"] == "own" for entry in read_ledger()))
    ]


def test_each_study_stands_on_the_page_of_all_and_on_one_page_of_its_kind():
    for study in STUDIES:
        named = [name for name, text in PAGES.items() if f"| {study.entry['id']} |" in text]
        assert len(named) == 2


def test_every_result_is_counted_once():
    assert Counter(result for results in VERDICTS.values() for result in results) == Counter(get_args(Result))
    assert {result for results in list(VERDICTS.values())[:3] for result in results} == set(RIGHT)
    cases = [outcome for study in STUDIES for outcome in study.cases]
    (_, right), *others = verdict_rates(cases)
    assert sum(row["hits"] for _, row in others) == right["n"] == len(cases)
    assert sum(row["hits"] for _, row in others[:3]) == right["hits"]


def test_a_study_s_figures_are_those_of_its_cases():
    for study in STUDIES:
        if study.stored is not None:
            assert study.stored["right"]["hits"] == sum(outcome.right for outcome in study.cases)
            assert study.stored["right"]["n"] == len(study.cases)
            written = json.dumps([outcome.as_json() for outcome in study.cases])
            assert json.loads(written) == study.stored["cases"]


def plan(passes: str, kinds: str, effects: str = "") -> dict[str, Any]:
    return {"passes": passes.split(), "kinds": kinds, "effects": effects}


@pytest.mark.parametrize(
    ("asked", "kind"),
    [
        (plan("found", ""), "mixed"),
        (plan("found", "none"), "clean"),
        (plan("found", "none,single"), "mixed"),
        (plan("found", "pair,scatter_with"), "pairs"),
        (plan("without", "single"), "left_out"),
        (plan("found without", "single"), "single"),
        (plan("found settled", "single", "time_delay"), "settled"),
    ],
)
def test_the_kind_of_a_study_is_that_of_its_plan(asked: dict[str, Any], kind: str):
    assert kind_of(asked) == kind
    assert kind in KINDS


def test_a_bad_study_and_one_of_another_truth_change_their_own_pools_alone():
    missed = replace(STUDIES[0].cases[0], result="missed")
    bad = replace(STUDIES[0], cases=(missed,) * 100, entry={**STUDIES[0].entry, "id": "bad"})
    assert readme_text((*STUDIES, bad)) != readme_text(STUDIES)
    strange = replace(bad, entry={**bad.entry, "truth": "strange"})
    more = pages((*STUDIES, strange))
    assert {name: more[name] for name in PAGES} == PAGES
    assert "0 of 100 (0 %" in more["blind_strange_all.md"]
    assert readme_text((*STUDIES, strange)) == readme_text(STUDIES)


def test_readme_tells_the_strangers_pool_beside_the_own_one():
    missed = replace(STUDIES[0].cases[0], result="missed", verdict="nothing_missing")
    other = replace(missed, result="wrong_name", verdict="named")
    right = replace(missed, result="named", verdict="named")
    entry = {**STUDIES[0].entry, "truth": STRANGER, "id": "strange"}
    own = tuple(study for study in STUDIES if study.entry["truth"] != STRANGER)
    told = readme_text((*own, replace(STUDIES[0], cases=(missed, other, right, right), entry=entry)))
    assert "2 of 4 (50 %" in told.splitlines()[-1]
    assert "1 of 4 (25 %" in told.splitlines()[-1]
    assert "stranger" not in readme_text(own)


def test_a_study_that_never_ended_is_listed():
    entry = {**STUDIES[0].entry, "id": "hung", "outcome": "begun"}
    hung = Study(entry=entry, stored=None, cases=(), left_out=(), settled=())
    assert "| hung | " in pages((*STUDIES, hung))["blind.md"]
    assert "begun, never ended" in pages((*STUDIES, hung))["blind.md"]


def test_a_stored_study_is_entered_afterwards(tmp_path):
    source = LEDGER.parent / next(entry["file"] for entry in read_ledger() if "file" in entry)
    ledger = tmp_path / "ledger.json"
    done = CliRunner().invoke(enter, [str(source), "--ledger", str(ledger)])
    assert done.exit_code == 0, done.output
    (study,) = read_studies(ledger)
    assert study.entry["entered"] == "afterwards"
    assert json.loads((tmp_path / study.entry["file"]).read_text()) == json.loads(source.read_text())
    (tmp_path / study.entry["file"]).unlink()
    with pytest.raises(InputError):
        read_studies(ledger)
