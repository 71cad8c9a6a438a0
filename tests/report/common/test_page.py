"""The frame of all pages: text is escaped, labels are set, pictures are whole."""

from __future__ import annotations

import math

import pytest

from haptid.report.common.charts import picture_of
from haptid.report.common.numbers import round_to_error, with_error
from haptid.report.common.page import Page, Section, Table
from haptid.report.common.style import figure, svg
from tests.report.reading import OWN_SCRIPTS, seen

NASTY = "</td><script>x</script> \"quoted\" 'single' & {{ 7*7 }} {% raw %} ]]> */ <!-- \\"


def page(synthetic=None):
    made = figure()
    axis = made.subplots()
    axis.plot([0, 1], [1, 0], label=NASTY)
    axis.set_title(NASTY)
    return Page(
        title=NASTY,
        lead=NASTY,
        synthetic=synthetic,
        sections=[
            Section(
                title=NASTY,
                anchor="a",
                paragraphs=[NASTY],
                pictures=[picture_of(made, caption=NASTY, alt=NASTY)],
                tables=[Table(header=[NASTY, "b"], rows=[[NASTY, "1"]], caption=NASTY)],
            )
        ],
        footer=[NASTY],
    ).html


def test_text_of_every_place_stays_text():
    shown = seen(page())
    assert shown.text.count(" ".join(NASTY.split())) >= 8
    assert shown.alternatives == [NASTY]
    assert shown.panels[0][0]["curves"][0]["label"] == NASTY
    assert shown.row(NASTY)[1] == "b"


@pytest.mark.parametrize(("synthetic", "labelled"), [(True, True), (False, False), (None, False)])
def test_only_synthetic_data_bear_the_label(synthetic, labelled):
    assert ("SYNTHETIC DATA" in seen(page(synthetic)).text) is labelled


def test_a_page_needs_nothing_from_elsewhere():
    text = page().replace(OWN_SCRIPTS[0], "")  # its first line is a comment with its address
    assert "http://" not in text
    assert "https://" not in text
    assert "<link" not in text


def test_a_picture_is_the_same_bytes_each_time():
    def drawn():
        made = figure()
        made.subplots().plot([0, 1], [1, 0])
        return svg(made)

    assert drawn() == drawn()


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (0.0151423, 0.000066, "0.015142 ± 0.000066"),
        (-3.0, 0.5, "-3.00 ± 0.50"),
        (1.5e-6, 2.1e-8, "(1.500 ± 0.021)e-06"),
        (2.0, 0.0, "2"),
        (2.0, math.nan, "2"),
        (math.nan, 1.0, "nan"),
    ],
)
def test_numbers_with_errors(value, std, text):
    assert with_error(value, std) == text


def test_rounded_numbers_keep_a_tenth_of_the_error():
    assert round_to_error(123.456, 0.1) == "123.46"
    assert round_to_error(0.0, 0.1) == "0"
    assert round_to_error(1.0, math.inf) == "1"


@pytest.mark.parametrize(("inches", "pixels"), [(4.0, 320), (9.0, 720)])
def test_a_picture_says_at_which_width_its_smallest_letters_can_be_read(inches, pixels):
    made = figure(inches, 2.0)
    made.subplots().set_title("letters of 9 pt beside numbers of 9 pt", fontsize=9)
    picture = picture_of(made, caption="c", alt="a")
    shown = Page(title="t", lead="l", synthetic=None, sections=[Section(title="s", pictures=[picture])]).html
    assert f"--readable:{pixels}px" in shown
    assert "<source" not in shown
