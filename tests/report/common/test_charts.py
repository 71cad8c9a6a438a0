"""Curves of pages: no spike is lost, numbers come back, and what a figure holds is what a reader gets."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from haptid.report.common.charts import LARGEST_STEP, panels_of, picture_of, thin_curves
from haptid.report.common.decimation import dots_to_draw, points_to_draw, rows_to_draw
from haptid.report.common.marks import tell
from haptid.report.common.page import Cell, Numbers, Page, Section, Table
from haptid.report.common.stored_page import content_of, read_page, write_page
from haptid.report.common.style import ACCENT, BAND, SIMULATED, figure, svg
from haptid.support.errors import InputError

T = np.linspace(0.0, 20.0, 50_000)


def unpacked(numbers: Numbers) -> np.ndarray:
    steps = np.frombuffer(base64.b64decode(numbers.steps), "<u2")
    values = numbers.low + steps / LARGEST_STEP * (numbers.high - numbers.low)
    return np.where(steps > LARGEST_STEP, np.nan, values)


@given(arrays(float, 700, elements=st.floats(-1e6, 1e6)))
def test_each_column_keeps_its_least_and_its_greatest_value(values):
    kept = rows_to_draw(values[:, None], 50)
    assert kept.size <= 2 * 50 + 2
    for begin, end in zip(range(0, 700, 14), range(14, 701, 14), strict=True):
        inside = values[kept[(kept >= begin) & (kept < end)]]
        assert (inside.min(), inside.max()) == (values[begin:end].min(), values[begin:end].max())


@pytest.mark.parametrize("place", [1, 12_345, 49_998])
def test_a_spike_of_one_sample_is_in_both_pictures(place):
    y = np.sin(T)
    y[place] = 7.5
    made = figure()
    made.subplots().plot(T, y)
    (panel,) = panels_of(made)
    assert panel.joint
    assert np.nanmax(unpacked(panel.curves[0].y)) == pytest.approx(7.5)
    assert unpacked(panel.curves[0].y).size < 2100
    thin_curves(made)
    assert max(made.axes[0].lines[0].get_ydata()) == 7.5


def test_a_value_that_is_not_finite_stays_out():
    assert rows_to_draw(np.full((100, 1), np.nan), 10).tolist() == [0, 99]
    made = figure()
    made.subplots().plot([0.0, 1.0, 2.0], [1.0, np.nan, 3.0])
    (panel,) = panels_of(made)
    assert unpacked(panel.curves[0].y).tolist() == pytest.approx([1.0, np.nan, 3.0], nan_ok=True)


def test_a_loop_keeps_a_point_wherever_it_reaches_another_pixel():
    x, y = np.cos(40 * T), np.sin(40 * T)
    kept = points_to_draw(x, y, 50, 50)
    far = np.hypot(np.diff(x[kept]), np.diff(y[kept]))
    assert kept.size < x.size
    assert far.max() < 3 * 2.0 / 49
    assert dots_to_draw(x, y, 50, 50).size < 4 * 50


def test_curves_bands_areas_and_labels_are_those_of_the_figure():
    made = figure()
    above, below = made.subplots(2, 1, sharex=True)
    above.plot([0, 1, 2], [3, 4, 5], color=SIMULATED, label="simulated")
    above.fill_between([0, 1, 2], [2, 3, 4], [4, 5, 6], color=BAND)
    above.set_title("a run")
    below.plot([0, 1, 2], [0.1, -0.1, 0.2], color=ACCENT, ls="--")
    below.axhspan(-0.3, 0.3, color=BAND)
    below.axvline(1.5)
    below.set_xlabel("time [s]")
    below.set_ylabel("residual")
    first, second = panels_of(made)
    assert (first.title, first.x_label, second.y_label) == ("a run", "time [s]", "residual")
    assert [(c.label, c.ink, c.dashed) for c in (*first.curves, *second.curves)] == [
        ("simulated", "simulated", False), ("", "accent", True),
    ]  # fmt: skip
    (area,) = first.fills
    assert unpacked(area.low) == pytest.approx([2, 3, 4], abs=1e-4)
    assert unpacked(area.high) == pytest.approx([4, 5, 6], abs=1e-4)
    assert second.bands == (pytest.approx((-0.3, 0.3)),)
    assert second.marks == (1.5,)


def test_interactive_pictures_survive_storing(tmp_path):
    made = figure()
    axis = made.subplots()
    axis.plot(T, np.sin(T), label="<b>")
    axis.fill_between(T, np.sin(T) - 1, np.sin(T) + 1, color=BAND)
    picture = picture_of(made, caption="c", alt="a")
    assert picture.panels[0].fills
    page = Page(title="t", lead="l", sections=[Section(title="s", pictures=[picture])], synthetic=None)
    path = write_page(tmp_path / "report.html", page)
    assert read_page(path).html == path.read_text(encoding="utf-8")
    assert write_page(path, page).read_bytes() == write_page(path, read_page(path)).read_bytes()


def test_a_stored_page_with_a_word_that_nobody_knows_is_one_line(tmp_path):
    table = Table(header=["a"], rows=[[Cell(text="a", word="fit-lonely")]])
    page = Page(title="t", lead="l", sections=[Section(title="s", tables=[table])], synthetic=None)
    path = write_page(tmp_path / "report.html", page)
    stored = gzip.decompress(content_of(path).read_bytes()).replace(b"fit-lonely", b"fit-nobody")
    content_of(path).write_bytes(gzip.compress(stored))
    with pytest.raises(InputError, match="fit-nobody"):
        read_page(path)


@pytest.mark.parametrize(("small", "pixels"), [(True, 0), (False, 704)])
def test_a_page_stored_without_widths_of_its_pictures_is_read(tmp_path, small, pixels):
    picture = picture_of(figure(), caption="c", alt="a")
    page = Page(title="t", lead="l", sections=[Section(title="s", pictures=[picture])], synthetic=None)
    path = write_page(tmp_path / "report.html", page)
    stored = json.loads(gzip.decompress(content_of(path).read_bytes()))
    (old,) = stored["sections"][0]["pictures"]
    del old["uri_for_phones"], old["readable_width"]
    old["small"] = small
    content_of(path).write_bytes(gzip.compress(json.dumps(stored).encode()))
    assert read_page(path).sections[0].pictures[0].readable_width == pixels


def test_a_picture_for_phones_that_is_not_part_of_the_page_is_refused(tmp_path):
    picture = picture_of(figure(), caption="c", alt="a", for_phones=figure(4.0))
    page = Page(title="t", lead="l", sections=[Section(title="s", pictures=[picture])], synthetic=None)
    path = write_page(tmp_path / "report.html", page)
    stored = json.loads(gzip.decompress(content_of(path).read_bytes()))
    stored["sections"][0]["pictures"][0]["uri_for_phones"] = "https://example.org/a.svg"
    content_of(path).write_bytes(gzip.compress(json.dumps(stored).encode()))
    with pytest.raises(InputError, match="not part of the page"):
        read_page(path)


@pytest.mark.parametrize("draw", ["bar", "names", "text", "image"])
def test_what_is_no_curve_stays_a_still_picture(draw):
    made = figure()
    axis = made.subplots()
    axis.plot([0, 1], [0, 1])
    if draw == "bar":
        axis.bar([0, 1], [1, 2])
    elif draw == "names":
        axis.set_yticks([0, 1], ["a", "b"])
    elif draw == "text":
        axis.text(0, 0, "here")
    else:
        axis.imshow(np.eye(2))
    assert picture_of(made, caption="c", alt="a").panels == ()


@pytest.mark.parametrize(("x", "place"), [(1.0, 0.0), (10.0, 0.5), (100.0, 1.0), (1e6, 1.0)])
def test_a_mark_lies_where_its_point_is_drawn_and_draws_nothing(x, place):
    def drawn(*, told: bool):
        made = figure(4.0, 2.0)
        made.set_layout_engine("none")
        axis = made.add_axes((0.25, 0.5, 0.5, 0.25))
        axis.set_xscale("log")
        axis.set_xlim(1.0, 100.0)
        axis.set_ylim(0.0, 1.0)
        axis.bar([2.0], [0.5])
        if told:
            tell(axis, x, 1.0, "a <b>", "row")
        return picture_of(made, caption="c", alt="a")

    (mark,) = drawn(told=True).marks
    assert mark.box == pytest.approx((0.25, mark.y, 0.75, mark.y))
    assert (mark.x, mark.y, mark.text) == (pytest.approx(0.25 + 0.5 * place), pytest.approx(0.25), "a <b>")
    assert drawn(told=True).uri == drawn(told=False).uri


def test_marks_survive_storing_and_bring_the_scripts(tmp_path):
    def made(width: float):
        drawn = figure(width)
        axis = drawn.subplots()
        axis.bar([1.0], [2.0])
        tell(axis, 1.0, 2.0, "</script>")
        return drawn

    picture = picture_of(made(8.0), caption="c", alt="a", for_phones=made(4.0))
    assert picture.marks[0] != picture.marks_for_phones[0]
    page = Page(title="t", lead="l", sections=[Section(title="s", pictures=[picture])], synthetic=None)
    path = write_page(tmp_path / "report.html", page)
    assert read_page(path).html == path.read_text(encoding="utf-8")
    assert page.html.count("</script>") == 3


def test_a_still_picture_follows_light_and_dark_paper_and_keeps_its_words():
    made = figure()
    axis = made.subplots()
    axis.plot([0.001234567, 1], [1, 1000], color=SIMULATED)
    axis.set_yscale("log")
    axis.text(0.5, 10.0, "0.123456 $x$")
    text = svg(made).decode()
    assert "prefers-color-scheme:dark" in text
    assert SIMULATED not in text.partition("</style>")[2]
    assert "var(--simulated)" in text
    assert "0.123456 $x$" in text
    assert "mathdefault" not in text
