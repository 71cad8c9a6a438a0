"""The pages say what the code holds: figures, tables, names of files, equations."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from docs.from_code import architecture, constants, friction, search_figure
from docs.from_runs import gallery, paper
from docs.parts.equations import BLOCK, TAG, mathml_of, with_equations
from haptid.model.device.reader import load_device
from haptid.model.friction.law import SLOTS, USE_OF_BRISTLE
from haptid.model.planning.locking_order import locking_order
from haptid.model.rigid_body.forward_dynamics import forward_dynamics
from haptid.support.installing.environment import ROOT

DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if "results" not in p.parts)
PACKAGES = {p.parent.name for p in ROOT.glob("*/__init__.py")}


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def test_the_architecture_is_that_of_the_contracts():
    page = text_of(architecture.PAGE)
    assert page == architecture.with_tables(page), "run python -m docs.generate"
    assert "| 2 | `equations/` |" in page


def test_the_one_name_says_which_types_come_in_and_go_out():
    taken, _, given = architecture.first_sentence(ROOT / "haptid").partition(" in; ")
    assert "`Campaign`" in taken
    assert {"`Identified`", "`Posteriors`", "`Missing`"} <= {word.strip(",") for word in given.split()}


def test_the_figure_of_the_data_flow_is_that_of_the_script():
    assert text_of(architecture.FIGURE) == architecture.data_flow(), "run python -m docs.generate"


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_files_named_in_a_page_exist(page: Path):
    named = re.findall(r"`([a-z_]+/[\w/.*]*)`", text_of(page))
    lost = [name for name in named if name.partition("/")[0] in PACKAGES and not list(ROOT.glob(name.rstrip("/")))]
    assert not lost


@pytest.mark.parametrize("page", [p for p in PAGES if BLOCK.search(text_of(p))], ids=lambda p: p.stem)
def test_equations_of_a_page_are_typeset_and_numbered_in_order(page: Path):
    blocks = [" ".join(match["tex"].split()) for match in BLOCK.finditer(text_of(page))]
    numbers = [int(TAG.search(block)["number"]) for block in blocks]
    assert numbers == list(range(1, len(numbers) + 1))
    for block in blocks:
        assert "<mrow>" in mathml_of(TAG.sub("", block))
    referred = {int(n) for n in re.findall(r"\((\d+)\)", BLOCK.sub("", text_of(page)))}
    assert referred <= set(numbers) | set(range(1900, 2100))


def test_a_command_that_is_not_understood_is_refused():
    with pytest.raises(ValueError, match="nosuchthing is not understood"):
        with_equations("```math\na \\nosuchthing b\n```")


def test_functions_stand_apart_from_their_arguments():
    assert '<mi>cos</mi><mspace width="0.167em" /><mi>q</mi>' in mathml_of("\\cos q")
    assert '<mi>cos</mi><mo stretchy="false">' in mathml_of("\\cos(q)")


def test_an_equation_is_typeset_with_its_number():
    html = with_equations("a\n\n```math\nx = \\dfrac{1}{2} \\tag{7}\n```\n\nb")
    assert 'class="equation" id="eq-7"' in html
    assert "(7)</span>" in html
    assert "```" not in html


def test_the_figure_of_the_search_is_that_of_the_script():
    assert text_of(search_figure.FIGURE) == search_figure.search_flow(), "run python -m docs.generate"


def test_tables_of_the_friction_page_are_those_of_the_laws():
    page = text_of(friction.PAGE)
    assert page == friction.with_tables(page), "run python -m docs.generate"
    assert set(friction.ACTS_ON) == {*SLOTS, USE_OF_BRISTLE}


@pytest.mark.parametrize("name", constants.list_constants())
def test_constants_of_a_theory_page_are_those_of_the_code(name: str):
    page = constants.THEORY / name
    assert text_of(page) == constants.with_tables(page), "run python -m docs.generate"
    prose = text_of(page).partition("## Constants")[0]
    unused = [c.symbol for c in constants.list_constants()[name] if c.symbol not in prose]
    assert not unused


def test_tables_of_the_paper_are_those_of_the_stored_results():
    page = text_of(paper.PAGE)
    stored = json.loads(paper.STORED.read_text(encoding="utf-8"))
    assert page == paper.with_tables(page, stored), "run python -m docs.from_runs.paper"
    assert [one["figure"] for one in stored["figures"]] == list(range(4, 12))


def test_tables_of_the_gallery_are_those_of_the_stored_results():
    page = text_of(gallery.PAGE)
    stored = json.loads(gallery.STORED.read_text(encoding="utf-8"))
    assert page == gallery.with_tables(page, stored), "run python -m docs.from_runs.gallery --tables"
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page):
        assert (DOCS / picture).is_file()


def test_the_gallery_shows_what_it_says():
    stored = json.loads(gallery.STORED.read_text(encoding="utf-8"))
    assert stored["missing"]["verdict"] == "named"
    k3 = stored["missing"]["k3"]
    assert abs(k3["value"] - k3["true"]) < 3 * k3["std"]
    assert set(stored["posterior"]) == set(gallery.TRUTH)


def test_the_computed_locking_order_is_the_paper_s():
    stages = locking_order(load_device("freedom6s")).stages
    assert tuple(tuple(stage.free) for stage in stages) == paper.SEQUENCE_OF_PAPER


def test_numbers_of_the_rigid_body_are_those_of_the_device():
    device = load_device("freedom6s")
    order = locking_order(device)
    new = [str(len(stage.new)) for stage in order.stages]
    operations = sum(expression.count_ops() for _, expression in forward_dynamics(device).definitions)
    text = text_of(constants.THEORY / "rigid_body.md")
    assert f"with {', '.join(new[:-1])} and {new[-1]} new parameters" in text
    assert f"reach {order.reached_home} of {order.full.rank} base parameters" in text
    assert f"takes {operations:,} operations" in text
