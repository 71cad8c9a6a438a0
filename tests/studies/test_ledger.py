"""The ledger: studies enter before they run, and none leaves; the generator's version changes with its code alone."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from haptid.support.errors import InputError
from studies.evidence.enter import plan_of
from studies.ledger.entries import LEDGER, RESULTS, add_entry, begin_study, end_study, read_ledger
from studies.ledger.generator import ROOT, digest_of, generator_at, generator_digest

PLAN: dict[str, Any] = {
    "cases": 2, "seed": 7, "kinds": "none", "sizes": "", "inputs": "rich", "effects": "", "without": "",
    "passes": ["found"], "limit_s": 60.0,
}  # fmt: skip
TOLD = {"command": "python -m studies.blind.run", "date": "2026-01-01", "git": "abc", "code": "c1", "generator": "g1"}
STUDY = {"worked_through": 1, "cases": []}


def test_a_study_enters_as_begun_and_ends_under_its_name(tmp_path: Path):
    ledger = tmp_path / "ledger.json"
    name = begin_study(ledger, tmp_path / "out", PLAN, TOLD)
    (entry,) = read_ledger(ledger)
    assert (entry["id"], entry["outcome"], entry["series"], entry["truth"]) == (name, "begun", 1, "own")
    assert {key: entry[key] for key in TOLD} == TOLD
    assert entry["plan"] == PLAN
    end_study(ledger, name, STUDY, complete=False)
    (entry,) = read_ledger(ledger)
    assert (entry["outcome"], entry["worked_through"]) == ("interrupted", 1)
    assert json.loads((tmp_path / entry["file"]).read_text()) == STUDY


def test_the_same_study_goes_on_and_any_other_is_an_entry_of_its_own(tmp_path: Path):
    ledger, out = tmp_path / "ledger.json", tmp_path / "out"
    first = begin_study(ledger, out, PLAN, TOLD)
    assert begin_study(ledger, out, PLAN, TOLD) == first
    other_code = begin_study(ledger, out, PLAN, {**TOLD, "code": "c2"})
    other_plan = begin_study(ledger, out, {**PLAN, "limit_s": 90.0}, {**TOLD, "code": "c2"})
    other_folder = begin_study(ledger, tmp_path / "fresh", PLAN, TOLD)
    names = [entry["id"] for entry in read_ledger(ledger)]
    assert names == [first, other_code, other_plan, other_folder]
    assert len(set(names)) == 4


def test_what_a_study_has_is_not_taken_back(tmp_path: Path):
    ledger = tmp_path / "ledger.json"
    name = begin_study(ledger, tmp_path / "out", PLAN, TOLD)
    end_study(ledger, name, STUDY, complete=False)
    with pytest.raises(InputError, match="the 1 cases that it had, got 0"):
        end_study(ledger, name, {**STUDY, "worked_through": 0}, complete=True)
    ledger.write_text('{"schema": "ledger/1", "studies": []}')
    with pytest.raises(InputError, match="no study leaves the ledger"):
        end_study(ledger, name, STUDY, complete=True)


def test_another_generator_begins_a_series():
    studies: list[dict[str, Any]] = []
    for generator in ("g1", "g2", "g1", None, "g3"):
        add_entry(studies, PLAN, {**TOLD, "generator": generator}, {"entered": "before", "outcome": "begun"})
    assert [entry["series"] for entry in studies] == [1, 2, 1, None, 3]


def test_a_file_that_is_no_ledger_is_refused(tmp_path: Path):
    path = tmp_path / "ledger.json"
    path.write_text('{"schema": "ledger/1", "studies": [{"id": "x"}]}')
    with pytest.raises(InputError, match="ledger"):
        read_ledger(path)


def test_the_generator_changes_with_its_code_and_not_with_its_words():
    code = 'def draw():\n    """Draw."""\n    return 1\n'
    words = '"""Module."""\n\n# why\ndef draw():\n    """Draw one,\n    and say so.\n    """\n\n    return 1\n'
    assert digest_of({"a.py": code}) == digest_of({"a.py": words})
    assert digest_of({"a.py": code}) != digest_of({"a.py": code.replace("1", "2")})
    assert digest_of({"a.c": "int a;"}) != digest_of({"a.c": "int a; /* b */"})
    assert generator_at("no such version") is None
    assert len(generator_digest()) == 12


def test_a_command_tells_the_plan():
    asked = {"cases": 3, "seed": 1, "kinds": "single", "effects": ""}
    for command, passes, limit in (
        ("python -m studies.blind.run", ["found", "without", "settled"], 1800.0),
        ("python -m studies.blind.run --no-whole --limit=60", ["without"], 60.0),
        ("python -m studies.blind.run --no-leave-out --limit 90", ["found", "settled"], 90.0),
    ):
        plan = plan_of({"asked": asked, "command": command})
        assert (plan["passes"], plan["limit_s"]) == (passes, limit)


def test_every_stored_study_is_in_the_ledger_as_it_is_stored():
    entries = read_ledger()
    assert len({entry["id"] for entry in entries}) == len(entries)
    filed = {entry["file"]: entry for entry in entries if "file" in entry}
    assert set(filed) == {f"{RESULTS}/{path.name}" for path in (LEDGER.parent / RESULTS).iterdir()}
    for file, entry in filed.items():
        stored = json.loads((LEDGER.parent / file).read_text(encoding="utf-8"))
        if "given_again" not in entry:
            assert {k: stored[k] for k in ("command", "date", "git", "code")} == {
                k: entry[k] for k in ("command", "date", "git", "code")
            }
        assert stored["asked"].items() <= entry["plan"].items()
        assert stored["worked_through"] == entry["worked_through"]
    for entry in entries:
        if "file" not in entry:
            assert entry["outcome"] == "begun" or entry["known"]


def test_no_study_left_the_ledger():
    path = LEDGER.relative_to(ROOT).as_posix()
    listed = subprocess.run(
        ["git", "log", "--format=%H", "--", path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    commits = listed.stdout.split()
    if not commits:
        pytest.skip("no history here")
    now = {entry["id"]: entry for entry in read_ledger()}
    for commit in commits:
        shown = subprocess.run(["git", "show", f"{commit}:{path}"], cwd=ROOT, capture_output=True, check=False)
        for entry in json.loads(shown.stdout)["studies"] if shown.returncode == 0 else []:
            assert entry["plan"] == now[entry["id"]]["plan"]
            assert (entry.get("worked_through") or 0) <= (now[entry["id"]].get("worked_through") or 0)
