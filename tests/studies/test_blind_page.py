"""The blind study's page from the stored result, and what its command refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.blind.page import headlines, main

STORED = Path(__file__).parents[2] / "docs" / "results" / "blind" / "1083-a22fed2071fd.json"


def called(path):
    return CliRunner().invoke(main, [str(path)])


@pytest.fixture
def study(tmp_path) -> Path:
    return Path(shutil.copy(STORED, tmp_path / "blind.json"))


def test_a_stored_study_gives_its_page(study):
    done = called(study)
    assert done.exit_code == 0, done.output
    data, page = json.loads(study.read_text(encoding="utf-8")), study.with_suffix(".md").read_text(encoding="utf-8")
    right = data["right"]
    assert f"Right verdicts: {right['hits']} of {right['n']} ({100 * right['share']:.0f} %" in page
    assert all(line in page and line in done.stdout for line in headlines(data))
    assert all(f"| {case['case']} |" in page for case in data["cases"] if case["result"] == "missed")
    assert study.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert study.with_suffix(".png").stat().st_size > 20_000


def changed(study, change):
    data = json.loads(study.read_text(encoding="utf-8"))
    change(data)
    study.write_text(json.dumps(data), encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda d: d.pop("right"), "the key 'right'"),
        (lambda d: d.update(schema="blind/2"), "schema: expected the blind.json of a study of schema 'blind/1'"),
        (lambda d: d.update(confusion={"a": {"b": "c"}}), "confusion.a.b: expected a whole number, got 'c'"),
        (lambda d: d.update(cases={}), "cases: expected a list"),
        (lambda d: d["coverage"].pop("all"), "all figures of a blind study, got KeyError: 'all'"),
        (lambda d: d["right"].update(hits=None, share="x"), "all figures of a blind study"),
    ],
)
def test_a_study_that_is_not_whole_is_one_line(study, change, part):
    changed(study, change)
    done = called(study)
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert part in line
    assert sorted(p.name for p in study.parent.iterdir()) == ["blind.json"]


def test_a_missing_study_is_one_line(tmp_path):
    done = called(tmp_path / "none.json")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert "none.json" in done.stderr


def test_help_says_what_is_made():
    done = CliRunner().invoke(main, ["--help"])
    assert done.exit_code == 0
    assert "blind study" in done.output
