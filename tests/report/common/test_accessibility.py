"""Pages in a browser: axe-core finds nothing, nothing overflows a phone, figures are drawn, nothing is loaded."""

from __future__ import annotations

import base64
import io
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.image import imread

from haptid.report.common.charts import picture_of
from haptid.report.common.cycles import cycles_picture
from haptid.report.common.page import Cell, Page, Section, Table, word_cell
from haptid.report.common.stored_page import write_page
from haptid.report.common.style import ACCENT, BAND, MEASURED, RESIDUAL, SIMULATED, figure, style
from haptid.report.common.words import WORDS
from haptid.report.identification.parameter_figures import interval_figure

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next((found for name in BROWSERS if (found := shutil.which(name))), None)
playwright = pytest.importorskip("playwright.sync_api", reason="drives the browser; a dependency of development")
axe = pytest.importorskip(
    "axe_playwright_python.sync_playwright", reason="brings axe-core; a dependency of development"
)
pytestmark = pytest.mark.skipif(BROWSER is None, reason=f"needs one of {', '.join(BROWSERS)} on the path")
WIDTHS = (1280, 390)
SEEN = "dark", "light"


def all_kinds_of_figures():
    t = np.linspace(0.0, 20.0, 5000)
    made = figure(8.0, 4.0)
    axes = made.subplots(2, 2, sharex="col")
    for above, below in axes.T:
        above.plot(t, np.sin(t), color=MEASURED, lw=3, alpha=0.35, label="measured")
        above.plot(t, np.sin(t) + 0.01, color=SIMULATED, label="simulated")
        above.fill_between(t, np.sin(t) - 0.2, np.sin(t) + 0.2, color=BAND)
        below.axhspan(-0.02, 0.02, color=BAND)
        below.plot(t, 0.01 * np.cos(9 * t), color=RESIDUAL)
        below.axvline(3.0)
        below.set_xlabel("time [s]")
    yield picture_of(made, caption="Two runs.", alt="measured, simulated and residual of two runs")
    loop = figure()
    axis = loop.subplots()
    axis.plot(np.cos(t), np.tanh(9 * np.cos(t)) + 0.1 * np.sin(t), color=ACCENT, label="friction")
    axis.set_xlabel("speed [rad/s]")
    axis.set_ylabel("friction [N m]")
    yield picture_of(loop, caption="A loop.", alt="friction over speed")
    logarithmic = figure()
    axis = logarithmic.subplots()
    axis.plot(t[1:], 1e-3 + t[1:] ** -2.0, color=SIMULATED)
    axis.set_xscale("log")
    axis.set_yscale("log")
    yield picture_of(logarithmic, caption="A spectrum.", alt="spectrum")
    wide, narrow = (
        interval_figure(["inertia", "Ks"], np.array([0.3, 210.0]), [True, False], width) for width in (8.5, 4.0)
    )
    yield picture_of(wide, caption="Intervals.", alt="width of each interval", for_phones=narrow)
    one = SimpleNamespace(file="a.csv", use="fit", excess=np.array([0.1, -0.2]), std=np.array([0.05, 0.05]))
    yield cycles_picture([one], "joint 4")


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    """A page with every element that pages have, and every word."""
    words = [word_cell(*key.split("-", 1)) for key in WORDS]
    glance = Table(
        header=("joint", "verdict", "what to do next", "files"),
        rows=[
            (Cell(text="joint 4", anchor="joint4"), word, "Use it.", Cell(links=("a.fmu", "b.json"))) for word in words
        ],
    )
    wide = Table(header=[f"parameter_{k}" for k in range(14)], rows=[["0.001234 ± 0.000056"] * 14], caption="Wide")
    shades = [[(i - j) / 3 for j in range(4)] for i in range(4)]
    rows = [[f"p{i}", *(f"{s:+.2f}" for s in row)] for i, row in enumerate(shades)]
    correlation = Table(header=["", "p0", "p1", "p2", "p3"], rows=rows, caption="Correlations", shades=shades)
    sections = [
        Section(title="Overview", anchor="overview", paragraphs=["Words."], tables=[wide, wide, correlation]),
        Section(title="Figures", anchor="figures", pictures=list(all_kinds_of_figures())),
        Section(
            title="Joint 4", anchor="joint4", pictures=list(all_kinds_of_figures())[:1], tables=[wide], folded=True
        ),
    ]
    title = "A_campaign_with_a_very_long_name_that_has_no_space_anywhere_and_goes_on_and_on"
    page = Page(title=title, lead="All is well.", sections=sections, synthetic=True, footer=["seed 0"], glance=glance)
    return write_page(tmp_path_factory.mktemp("pages") / "report.html", page)


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def visit(browser):
    """Open a page at a width, unfold all, and scroll through it, so that every figure is drawn."""
    contexts = []

    def opened(path: Path, width: int, scheme: str = "light", *, scripts: bool = True):
        context = browser.new_context(
            viewport={"width": width, "height": 900}, color_scheme=scheme, java_script_enabled=scripts
        )
        contexts.append(context)
        shown = context.new_page()
        shown.errors, shown.asked = [], []
        shown.on("pageerror", lambda error: shown.errors.append(str(error)))
        shown.on("console", lambda told: shown.errors.append(told.text) if told.type == "error" else None)
        shown.on("request", lambda request: shown.asked.append(request.url))
        shown.goto(path.as_uri())
        if scripts:
            shown.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
            for place in range(0, shown.evaluate("document.documentElement.scrollHeight") + 1, 800):
                shown.evaluate(f"scrollTo(0, {place})")
                shown.wait_for_timeout(30)
        return shown

    yield opened
    for context in contexts:
        context.close()


@pytest.mark.parametrize("scheme", SEEN)
@pytest.mark.parametrize("width", WIDTHS)
def test_axe_finds_no_violation(visit, path, width, scheme):
    found = axe.Axe().run(visit(path, width, scheme)).response
    assert found["passes"]
    assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []


def test_axe_finds_what_is_wrong(visit, path, tmp_path):
    spoilt = tmp_path / "spoilt.html"
    text = path.read_text(encoding="utf-8")
    spoilt.write_text(text.replace(' tabindex="0"', "").replace(' lang="en"', ""), encoding="utf-8")
    found = {one["id"] for one in axe.Axe().run(visit(spoilt, 390)).response["violations"]}
    assert {"html-has-lang", "scrollable-region-focusable"} <= found


@pytest.mark.parametrize("width", WIDTHS)
def test_figures_are_drawn_without_an_error_and_nothing_is_loaded(visit, path, width):
    shown = visit(path, width)
    assert shown.errors == []
    assert [url for url in shown.asked if not url.startswith(("data:", "file:"))] == []
    assert len(shown.asked) == len(set(shown.asked))
    # Two runs of two panels twice, a loop and a spectrum; intervals and cycles stay still.
    assert shown.locator("canvas").count() == 10
    assert shown.locator(".still:visible").count() == 2
    pixels = "one.getContext('2d').getImageData(0, 0, one.width, one.height).data.buffer"
    inked = f"(one) => new Set(new Uint32Array({pixels})).size"
    assert all(shown.locator("canvas").nth(k).evaluate(inked) > 3 for k in range(10))


def test_a_phone_scrolls_only_what_is_wide_and_its_figures_have_letters_to_read(visit, path):
    shown = visit(path, 390)
    assert shown.evaluate("document.documentElement.scrollWidth") == 390
    assert shown.locator("canvas").first.bounding_box()["width"] > 300
    sizes = shown.evaluate(
        "[...document.querySelectorAll('.u-legend')].map((one) => parseFloat(getComputedStyle(one).fontSize))"
    )
    assert min(sizes) >= 11
    # What scrolls has a shadow at its edge, and a value stands on one line with its error.
    for what in (".still:visible", ".scroll:visible"):
        style = shown.locator(what).first.evaluate("one => getComputedStyle(one).backgroundAttachment")
        assert style == "local, local, scroll, scroll"


@pytest.mark.parametrize("scripts", [True, False])
def test_letters_of_still_pictures_have_ten_pixels_on_a_phone(visit, path, scripts):
    """Pictures of the width of a screen were shrunk, and their letters had 4 pixels."""
    shown = visit(path, 390, scripts=scripts)
    pictures = shown.locator(".still:visible img").all()
    assert len(pictures) == (2 if scripts else 5)
    for image in pictures:
        drawn = base64.b64decode(image.evaluate("one => one.currentSrc").partition(",")[2]).decode()
        points = float(re.search(r'<svg[^>]* width="([0-9.]+)pt"', drawn)[1])
        letters = min(float(size) for size in re.findall(r"font-size: ([0-9.]+)px", drawn))
        assert letters * image.bounding_box()["width"] / points >= 9.99


def test_a_figure_drawn_for_phones_is_shown_whole_there_and_nowhere_else(visit, path):
    widths = {}
    for width in WIDTHS:
        still = visit(path, width).locator(".still:visible:has(source)").first
        widths[width] = still.evaluate("one => one.querySelector('img').naturalWidth")
        assert still.evaluate("one => one.scrollWidth - one.clientWidth") <= 0
    assert widths[390] < widths[1280]


@pytest.fixture(scope="module")
def wordy(tmp_path_factory) -> Path:
    """A page with the longest names and statuses."""
    long = "joint0_coulomb_amplifier_lag_position_dependent_friction_load_dependent_friction"
    header = ("joint", "verdict", "missing", "missed before", "missed after", "× noise", "worst run")
    header += ("what to do next", "files")
    action = "Either model serves: choose by what is known of the machine."
    name = Cell(text="joints 0, 1, posture 12", anchor="joints01-12")
    row = (
        name,
        word_cell("verdict", "ambiguous"),
        "amplitude_scatter, amplifier_lag",
        "0.645 mrad",
        "0.101 mrad",
        "1.02",
    )
    row += (f"{long}.csv (validate)", action, Cell(links=("joint0.json", f"../fmu/{long}.fmu")))
    alone = ("1", *row[1:-1], Cell(links=("identification.json",)))
    unfit = Cell(text="uncertain: the model leaves 2.4 times the noise", word="unfit-uncertain")
    known = (
        "inertia",
        "0.00399989 ± 0.00000050",
        "kg m^2",
        unfit,
        "0.00399",
        "[3.99e-05, 0.399]",
        "inertia at the joint",
    )
    columns = ("parameter", "value ± std", "unit", "status", "first guess", "bounds", "meaning")
    overview = ("configuration", "fit/noise", "validate/noise", "starts", "best basin", "fit [s]", "outcome")
    fits = [
        (
            "joints 0, 1, posture 12", "160587 (4.34 rad, 220 % of the range)", "23842 (640 mrad, 35 % of the range)",
            "12", "12 of 12", "1234.5", word_cell("fit", outcome),
        )
        for outcome in ("converged", "above_noise", "unexplained", "torque_scored")
    ]  # fmt: skip
    tables = [
        Table(header=columns, rows=[known]),
        Table(header=("run", "use"), rows=[(f"{long}.csv", "fit")]),
        Table(header=overview, rows=fits),
    ]
    page = Page(
        title="Joint 0", lead="l", sections=[Section(title="Joint 0", tables=tables)], synthetic=True,
        glance=Table(header=header, rows=[row, alone]),
    )  # fmt: skip
    return write_page(tmp_path_factory.mktemp("wordy") / "report.html", page)


LINES_OF_WORDS = """one => {
    const lines = [];
    for (const text of [...one.childNodes].filter(node => node.nodeType === Node.TEXT_NODE)) {
        for (const word of text.data.matchAll(/\\S+/g)) {
            const range = document.createRange();
            range.setStart(text, word.index);
            range.setEnd(text, word.index + word[0].length);
            lines.push(new Set([...range.getClientRects()].map(box => Math.round(box.top))).size);
        }
    }
    return lines;
}"""
"""Number of lines on which each word of an element stands."""


@pytest.mark.parametrize("width", WIDTHS)
def test_no_word_of_an_outcome_is_broken(visit, wordy, width):
    """Beside wide cells an outcome read "converg/ed"."""
    shown = visit(wordy, width)
    words = shown.locator("td .word").all()
    assert len(words) >= 5
    for word in words:
        assert set(word.evaluate(LINES_OF_WORDS)) == {1}, word.inner_text()


@pytest.mark.parametrize("width", WIDTHS)
def test_names_break_beside_dots_and_underscores_alone(visit, wordy, width):
    """Where a joint had no FMU, its column of files read "identification.jso/n", and an effect "amplitude_sc/atter"."""
    shown = visit(wordy, width)
    (link,) = shown.locator(".glance a[href='identification.json']").all()
    effect = shown.locator(".glance td[data-label='missing']").first
    for name in (link, effect):
        assert set(name.evaluate(LINES_OF_WORDS)) == {1}


@pytest.mark.parametrize("width", WIDTHS)
def test_no_word_of_a_joint_s_name_is_broken(visit, wordy, width):
    """A name beside wide cells read "joint 0, postur/e 12"."""
    shown = visit(wordy, width)
    name = shown.locator(".glance td[data-label='joint'] a").first
    assert set(name.evaluate(LINES_OF_WORDS)) == {1}


KEEP_LABELS = """() => {
    window.labels = [];
    const draw = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        const turned = Math.abs(this.getTransform().b) > 0.5;
        if (turned) { window.labels.push([text, this.measureText(text).width]); }
        return draw.call(this, text, ...place);
    };
}"""
"""Notes every text that is drawn upright: its width in pixels."""


def test_a_label_of_a_figure_is_no_longer_than_its_axis(visit, tmp_path):
    """The label "spectrum over the noise [1]" was cut."""
    label = "spectrum over the noise [1]"
    with style():
        drawn = figure(4.0, 3.0)
        axes = drawn.subplots()
        axes.plot([0.0, 1.0], [0.0, 1.0])
        axes.set_ylabel(label)
    picture = picture_of(drawn, caption="A line.", alt="A line")
    section = Section(title="Joint 0", pictures=(picture,))
    page = Page(title="Joint 0", lead="l", sections=[section], synthetic=True)
    shown = visit(write_page(tmp_path / "report.html", page), 1280)
    shown.evaluate(KEEP_LABELS)
    shown.set_viewport_size({"width": 1100, "height": 900})
    shown.wait_for_timeout(200)
    found = [one for one in shown.evaluate("window.labels") if one[0] == label]
    assert found
    plot = 146  # height of a picture less its axis
    assert all(width <= plot for _, width in found)


@pytest.mark.parametrize("width", WIDTHS)
def test_long_names_of_files_wrap_and_statuses_stand_on_the_screen(visit, wordy, width):
    shown = visit(wordy, width)
    for part in shown.locator(".scroll").all():
        assert part.evaluate("one => one.scrollWidth - one.clientWidth") <= 0
    status = shown.locator("td[data-label='status'] .word").bounding_box()
    assert status["x"] + status["width"] <= width
    assert status["height"] < 60


def test_a_value_with_its_error_breaks_nowhere_and_a_still_picture_takes_the_whole_width(visit, path):
    narrow = visit(path, 390)
    for cell in narrow.locator("td[data-label*='±']").all():
        assert cell.evaluate("one => getComputedStyle(one).whiteSpace") == "nowrap"
    wide = visit(path, 1280)
    for still in wide.locator(".still:visible").all():
        widths = still.bounding_box()["width"], still.locator("img").bounding_box()["width"]
        assert widths[0] == pytest.approx(widths[1], abs=1)


def test_a_drag_enlarges_all_panels_of_a_run_and_a_double_click_goes_back(visit, path):
    shown = visit(path, 1280)
    first = shown.locator(".u-over").first
    first.scroll_into_view_if_needed()
    box = first.bounding_box()

    def drawn(number: int) -> np.ndarray:
        content = shown.locator("canvas").nth(number).evaluate("(one) => one.toDataURL()").partition(",")[2]
        return imread(io.BytesIO(base64.b64decode(content)))

    before = [drawn(k) for k in range(3)]
    shown.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 40)
    shown.mouse.down()
    shown.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 40, steps=4)
    shown.mouse.up()
    shown.wait_for_timeout(100)
    changed = [np.mean(np.abs(drawn(k) - before[k]).max(axis=2) > 0.1) for k in range(3)]
    assert min(changed[:2]) > 0.02
    assert changed[2] == 0  # another run
    first.dblclick(position={"x": 60, "y": 40})
    shown.wait_for_timeout(100)
    # The positions of letters may differ by a part of a pixel.
    assert max(np.mean(np.abs(drawn(k) - before[k]).max(axis=2) > 0.1) for k in range(3)) < 0.002


def test_a_loop_is_enlarged_in_both_directions_and_tells_the_points_next_to_the_pointer(visit, path):
    shown = visit(path, 1280)
    loop = shown.locator("figure", has=shown.locator("img[alt='friction over speed']"))
    loop.scroll_into_view_if_needed()
    box = loop.locator(".u-over").bounding_box()

    def point() -> tuple[float, float]:
        shown.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.25 * box["height"])
        told = loop.locator(".u-value").inner_text()
        x, y = re.fullmatch(r"speed ([-0-9.e]+), friction ([-0-9.e]+)", told).groups()
        return float(x), float(y)

    x, y = point()
    assert abs(x) < 0.2
    assert 0.4 < y < 0.8
    shown.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 2)
    shown.mouse.down()
    shown.mouse.move(box["x"] + box["width"] - 2, box["y"] + 0.3 * box["height"], steps=4)
    shown.mouse.up()
    x, y = point()
    assert x > 0.5
    assert y > 0.9
    loop.locator(".u-over").dblclick(position={"x": 60, "y": 40})
    assert abs(point()[0]) < 0.2


@pytest.mark.parametrize("width", WIDTHS)
def test_a_picture_of_intervals_tells_the_value_at_the_pointer_and_by_keys(visit, path, width):
    shown = visit(path, width)
    bars = shown.locator("figure", has=shown.locator("img[alt='width of each interval']"))
    bars.scroll_into_view_if_needed()
    box, line = bars.locator("img").bounding_box(), bars.locator(".told")
    shown.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 5)
    assert line.inner_text() == "Ks: ± 210 % of the value (not identified, or the model does not fit)"
    shown.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.6 * box["height"])
    assert line.inner_text() == "inertia: ± 0.3 % of the value"
    spot = bars.locator(".spot").bounding_box()
    assert box["x"] < spot["x"] < box["x"] + box["width"]
    assert box["y"] < spot["y"] < box["y"] + box["height"]
    cycles = shown.locator("figure", has=shown.locator("img[alt='joint 4, amplitudes of cycles']"))
    cycles.locator(".still").focus()
    told = []
    for key in ("ArrowRight", "ArrowRight", "ArrowRight", "ArrowLeft"):
        shown.keyboard.press(key)
        told.append(cycles.locator(".told").inner_text())
    first, second = "a.csv (fit), cycle 1: +10 ± 9.8 %", "a.csv (fit), cycle 2: -20 ± 9.8 %"
    assert told == [first, second, first, second]
    spot, still = cycles.locator(".spot").bounding_box(), cycles.locator(".still").bounding_box()
    assert still["x"] < spot["x"] < still["x"] + still["width"]


def test_a_cell_of_a_matrix_tells_its_row_and_its_column(visit, path):
    shown = visit(path, 1280)
    cell = shown.locator("td.shade").nth(1)
    cell.hover()
    assert cell.get_attribute("title") == "p0, p1: -0.33"


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        ("loop", ["curves"]),
        ("intervals", ["bars and intervals"]),
        ("loop intervals still matrix", ["curves", "bars and intervals", "Matrices", "still"]),
        ("still", []),
        ("", []),
    ],
)
def test_the_hint_promises_what_the_figures_of_the_page_do(visit, tmp_path, kinds, said):
    drawn = list(all_kinds_of_figures())
    bars = figure()
    bars.subplots().bar([1.0], [1.0])
    by_kind = {"loop": drawn[1], "intervals": drawn[3], "still": picture_of(bars, caption="Bars.", alt="bars")}
    pictures = [picture for kind, picture in by_kind.items() if kind in kinds]
    matrix = Table(header=["", "p0"], rows=[["p0", "+1.00"]], caption="Correlations", shades=[[0.0]])
    section = Section(title="s", anchor="s", pictures=pictures, tables=[matrix] if "matrix" in kinds else [])
    page = Page(title="t", lead="l", sections=[section], synthetic=None)
    hint = visit(write_page(tmp_path / "report.html", page), 1280).locator(".hint")
    told = hint.inner_text() if hint.count() else ""
    assert [word for word in ("curves", "bars and intervals", "Matrices", "still") if word in told] == said


def test_on_paper_a_caption_stays_with_its_table_and_a_matrix_on_its_page(visit, tmp_path):
    short, long = (Table(header=["a", "b"], rows=[["1", "2"]] * rows, caption="Rows") for rows in (12, 13))
    matrix = replace(long, caption="Correlations", shades=[[0.5]] * 13)
    page = Page(title="t", lead="l", sections=[Section(title="s", tables=[short, long, matrix])], synthetic=None)
    shown = visit(write_page(tmp_path / "report.html", page), 1280)
    shown.emulate_media(media="print")
    style = "(one, name) => getComputedStyle(one)[name]"
    assert {one.evaluate(style, "breakAfter") for one in shown.locator("caption, thead").all()} == {"avoid"}
    assert [one.evaluate(style, "breakInside") for one in shown.locator(".scroll").all()] == ["avoid", "auto", "avoid"]


def test_on_paper_nothing_tells_values(visit, path):
    shown = visit(path, 1280)
    shown.locator(".still:visible").first.hover()
    whole = shown.locator(".told:visible, .spot:visible, .hint:visible")
    assert whole.count() == 4
    shown.emulate_media(media="print")
    assert whole.count() == 0


def test_without_scripts_every_figure_is_a_still_picture(visit, path):
    shown = visit(path, 1280, scripts=False)
    assert shown.locator("canvas").count() == 0
    assert shown.locator(".still:visible").count() == 5


def test_on_paper_figures_are_still_pictures_on_white(visit, path):
    shown = visit(path, 1280, "dark")
    shown.emulate_media(media="print", color_scheme="dark")
    assert shown.locator("canvas:visible").count() == 0
    assert shown.locator(".still:visible").count() == 6
    assert shown.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


def test_dark_paper_is_dark(visit, path):
    shown = visit(path, 1280, "dark")
    assert shown.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 24, 29)"


def test_a_link_of_the_first_screen_unfolds_the_joint(visit, path):
    shown = visit(path, 1280)
    shown.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = false; })")
    shown.locator(".glance a", has_text="joint 4").first.click()
    assert shown.locator("details").first.get_attribute("open") is not None
