"""The figures of the house: what is counted, and that the page shows what is stored."""

from __future__ import annotations

import ast
import json
from collections import Counter

import pytest

from benchmarks.house import (
    Module,
    comment_lines,
    count_statements,
    cycles_of,
    figures_of,
    imports_of,
    is_bare_participle,
    longest_chain,
    numeric_constants,
    page_of,
    public_docstrings,
    reached_from,
)
from haptid.support.installing.environment import ROOT

RESULTS = ROOT / "docs" / "results"
PACKAGES = (
    "api",
    "discrepancy",
    "fmu_build",
    "identification",
    "measurement",
    "model",
    "noise",
    "report",
    "support",
    "uq",
    "virtual_device",
    "haptid",
)
MOST_MODULES = 12
"""Most modules of a room, beside the one that says what the room is for."""


def module(text: str, name: str = "model.a") -> Module:
    return Module(name, "model", text, ast.parse(text))


def test_the_page_shows_the_stored_figures():
    stored = json.loads((RESULTS / "house.json").read_text(encoding="utf-8"))
    assert (RESULTS / "house.md").read_text(encoding="utf-8") == page_of(stored)


def test_lines_of_studies_are_not_shipped():
    text = 'def f():\n    """One."""\n'
    study = Module("studies.a", "studies", 3 * text, ast.parse(text))
    figures = figures_of([module(text), study])
    assert (figures["lines"], figures["shipped_lines"]) == (8, 2)


def test_the_page_says_why_an_aim_was_missed_with_the_figures_of_first_and_last_tree():
    stored = json.loads((RESULTS / "house.json").read_text(encoding="utf-8"))
    first, last = stored["trees"][0]["figures"], stored["trees"][-1]["figures"]
    missed = page_of(stored).partition("## Aims missed, and why")[2]
    assert f"| modules reached from `discrepancy.run` | {first['reached_from_discrepancy']} |" in missed
    assert f"| {first['shipped_lines']:,} | {last['shipped_lines']:,} |" in missed


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("def made(): ...", True),
        ("def _judged(): ...", True),
        ("def need(): ...", False),
        ("def refit_candidate(): ...", False),
        ("@property\ndef shared(self): ...", False),
    ],
)
def test_bare_participles(source: str, expected: bool):
    assert is_bare_participle(ast.parse(source).body[0]) is expected


def test_counts_of_one_module():
    text = 'import math\nA = 1\nB = (2, -3 / 4)\nC = "x"\nD = math.pi  # why\ndef f():\n    pass  # noqa: D103\n'
    assert numeric_constants(module(text)) == 2
    assert comment_lines(module(text)) == 1
    assert count_statements(ast.parse("for i in x:\n    if i:\n        break").body) == 3


def test_docstrings_of_public_names_only():
    text = 'def f():\n    """One."""\ndef _g():\n    """Two."""\nclass A:\n    def m(self):\n        """Three."""\n'
    assert list(public_docstrings(ast.parse(text))) == ["One.", "Three."]


@pytest.mark.parametrize(
    "line",
    ["from haptid.model.b import x", "from haptid.model import b", "import haptid.model.b", "from model.b import x"],
)
def test_imports_of_either_tree(line: str):
    assert imports_of(module(line), {"model", "model.a", "model.b"}) == {"model.b"}


def test_chain_and_reach():
    graph = {"a": {"b", "c"}, "b": {"c"}, "c": set(), "d": {"a"}}
    assert longest_chain(graph) == 4
    assert not cycles_of(graph)
    assert reached_from(graph, "a") == {"a", "b", "c"}


def test_a_cycle_is_counted_and_is_one_link_of_a_chain():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set()}
    assert cycles_of(graph) == [{"b", "c"}]
    assert longest_chain(graph) == 3


def test_no_room_holds_more_than_twelve_modules():
    rooms = Counter(
        path.parent.relative_to(ROOT).as_posix()
        for top in (*PACKAGES, "benchmarks", "docs", "studies")
        for path in (ROOT / top).rglob("*.py")
        # haptid/ holds links to the packages beside modules of its own.
        if path.name != "__init__.py" and path.resolve().is_relative_to(ROOT / top)
    )
    assert rooms["haptid"] > 0
    assert {room: count for room, count in rooms.items() if count > MOST_MODULES} == {}
