"""Every word in which a result judges has a meaning and an action, and stands in the reference."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest

from docs.from_code import outcomes
from haptid.discrepancy.verdict.verdict import Verdict
from haptid.identification.result.outcome import Outcome
from haptid.report.common.page import Cell, Page, Section, Table, word_cell
from haptid.report.common.stored_page import read_page, write_page
from haptid.report.common.words import FITS, MORE_WORDS, PLAIN_WORDS, STATUSES, VERDICTS, WORDS
from haptid.support.installing.environment import ROOT
from tests.report.reading import seen

REFERENCE = Path(outcomes.PAGE)


def words_of(group) -> set[str]:
    return {word.key.partition("-")[2] for word in group}


def test_every_outcome_of_a_fit_has_its_word():
    assert words_of(FITS) == {outcome.label for outcome in Outcome}


def test_every_verdict_of_a_search_has_its_word():
    # A search in a torque names a part, beside what a search in a position says.
    assert words_of(VERDICTS) == {*get_args(Verdict), "partly_named"}


def test_every_status_of_a_parameter_has_its_word():
    assert words_of(STATUSES) == {"identified", "fixed", "prior", "unidentifiable", "at_bound"}


@pytest.mark.parametrize("word", WORDS.values(), ids=lambda word: word.key)
def test_a_word_says_what_it_means_and_what_to_do(word):
    assert word.meaning.endswith(".")
    assert word.action.endswith(".")
    assert word.meaning in REFERENCE.read_text(encoding="utf-8")


def test_the_reference_is_made_from_the_words():
    page = REFERENCE.read_text(encoding="utf-8")
    assert page == outcomes.with_tables(page), "run python -m docs.generate"


def text_of_title(page: Path) -> str:
    return page.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def page_with(*words: tuple[str, str]) -> Page:
    table = Table(header=["what"], rows=[[word_cell(*word)] for word in words])
    return Page(title="t", lead="l", sections=[Section(title="s", tables=[table])], synthetic=None)


def test_a_word_of_a_page_links_to_its_meaning_in_the_page():
    shown = seen(page_with(("fit", "above_noise"), ("status", "prior"), ("fit", "above_noise")).html)
    assert {"#word-fit-above_noise", "#word-status-prior"} <= set(shown.links)
    assert shown.text.count(WORDS["fit-above_noise"].meaning) == 1
    assert f"{WORDS['fit-above_noise'].meaning} What to do: {WORDS['fit-above_noise'].action}" in shown.text
    assert MORE_WORDS in shown.paragraphs
    assert all(place in MORE_WORDS for place in (str(REFERENCE.relative_to(ROOT)), text_of_title(REFERENCE)))
    assert WORDS["fit-converged"].meaning not in shown.text


def test_the_first_screen_has_plain_words_beside_what_is_jargon():
    glance = Table(header=["verdict"], rows=[[word_cell("fit", "lonely")], [word_cell("fit", "converged")]])
    shown = seen(replace(page_with(("fit", "lonely")), glance=glance).html)
    (first,) = [table for table in shown.tables if table.section == ""]
    assert first.rows[1:] == [["lonely reached by one start alone, above the noise"], ["converged"]]
    assert shown.table("s").rows[1:] == [["lonely"]]


def test_plain_words_are_of_words_that_there_are():
    assert set(PLAIN_WORDS) <= set(WORDS)


def test_a_word_that_is_not_known_is_text_alone():
    shown = seen(page_with(("status", "of another version")).html)
    assert "of another version" in shown.text
    assert not [link for link in shown.links if link.startswith("#word")]


def test_words_and_links_survive_storing(tmp_path):
    row = [word_cell("fit", "lonely"), Cell(text="joint 4", anchor="s"), Cell(links=["a b.fmu", "../c.json"])]
    glance = Table(header=["verdict", "joint", "files"], rows=[row])
    page = replace(page_with(("fit", "fixed")), sections=[Section(title="s", anchor="s")], glance=glance)
    path = write_page(tmp_path / "report.html", page)
    assert read_page(path).html == path.read_text(encoding="utf-8")
    assert {"a%20b.fmu", "../c.json", "#s"} <= set(seen(page.html).links)
