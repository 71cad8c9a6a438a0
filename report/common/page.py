"""The page of all reports: `Page` of `Section`s in, self-contained HTML out."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.resources import files

import jinja2
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup, escape

from haptid.identification.result.outcome import UNCERTAIN, tell_status
from haptid.report.common.style import inks_css
from haptid.report.common.words import MORE_WORDS, WORDS, Word, word_of

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("haptid.report.common", ""),
    autoescape=True,  # titles and names of files come from users
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,  # a misspelt name in the template is an error, not a gap in the page
)
HEADERS_OF_CARDS = ("status", "verdict", "outcome", "95 % interval", "change in percent")
"""Columns by which a table has more to say in a row than a phone is wide."""
SCRIPTS = ("uPlot.iife.min.js", "page.js")
"""Scripts of a page with a picture that enlarges or tells values: the library, and what feeds it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A cell of a table that is more than its text.

    Parameters
    ----------
    text
        What the reader sees.
    word
        Key of the word in `WORDS` that the text stands for: the cell links to its explanation, and has its colour and
        sign. None where empty.
    anchor
        Section of the page that the text links to; none where empty.
    links
        Files that the cell links to, relative to the page, after the text.
    """

    text: str = ""
    word: str = ""
    anchor: str = ""
    links: Sequence[str] = ()


def word_cell(group: str, word: str) -> Cell:
    """Return the cell of a word as files hold it.

    Parameters
    ----------
    group
        Group of the word, as ``status``.
    word
        As ``at_bound``.

    Returns
    -------
    Cell
        Text alone where the group has no such word, as in a file of another version.
    """
    key = f"{group}-{word}"
    return Cell(text=word, word=key if key in WORDS else "")


def status_cell(status: str, outcome: str) -> Cell:
    """Return the cell of a parameter's status.

    Parameters
    ----------
    status
        Status of the parameter in the fit.
    outcome
        Label of the fit's outcome.

    Returns
    -------
    Cell
        With the word that terminal, API and FMUs tell, too.
    """
    told = tell_status(status, outcome)
    return word_cell("unfit" if told == UNCERTAIN else "status", told)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of a page.

    Parameters
    ----------
    header
        Texts of the header cells.
    rows
        Cells, row by row.
    caption
        Text above the table; none where empty.
    shades
        Numbers from −1 to 1 behind the cells after the first, row by row, which colour them; none where empty.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str | Cell]]
    caption: str = ""
    shades: Sequence[Sequence[float]] = ()

    @property
    def has_cards(self) -> bool:
        """Whether a phone shows each row as lines below one another: a table with sentences is too wide to scroll."""
        return any(column in HEADERS_OF_CARDS for column in self.header)


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbers:
    """Numbers of a curve to a 65 534th of their range, which no screen tells from more, in less than three characters.

    Parameters
    ----------
    low, high
        Least and greatest finite number.
    steps
        Unsigned 16-bit integers in base64: 0 for ``low``, 65534 for ``high``, 65535 for what is not finite.
    """

    low: float
    high: float
    steps: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A curve of an interactive panel.

    Parameters
    ----------
    label
        Name in the legend; none where empty.
    ink
        Role of its colour in `INKS`, or the colour itself.
    width
        Width of the line [point].
    opacity
        1 where nothing shines through.
    dashed, dots
        Whether the line is dashed, and whether there are dots in place of a line.
    x, y
        Coordinates.
    """

    label: str
    ink: str
    width: float
    opacity: float
    dashed: bool
    dots: bool
    x: Numbers
    y: Numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Fill:
    """An area between two curves of an interactive panel, over the abscissa of its curves.

    Parameters
    ----------
    ink
        As `Curve` has it.
    opacity
        1 where nothing shines through.
    low, high
        Ends of the area.
    """

    ink: str
    opacity: float
    low: Numbers
    high: Numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """A panel of an interactive picture.

    Parameters
    ----------
    title, x_label, y_label
        Texts.
    column
        Column of the picture: panels of one column stand below one another and are zoomed together.
    joint
        Whether all curves lie over the same increasing abscissa.
    x_log, y_log
        Whether an axis is logarithmic.
    x_range, y_range
        Ends of the axes before any zoom.
    bands
        Ends of shaded bands over the whole width.
    levels, marks
        Ordinates of horizontal and abscissas of vertical lines.
    curves
        Curves in the order in which they are drawn.
    fills
        Areas below the curves.
    """

    title: str
    x_label: str
    y_label: str
    column: int
    joint: bool
    x_log: bool
    y_log: bool
    x_range: Sequence[float]
    y_range: Sequence[float]
    bands: Sequence[Sequence[float]]
    levels: Sequence[float]
    marks: Sequence[float]
    curves: Sequence[Curve]
    fills: Sequence[Fill] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A point of a still picture with what a page tells there.

    Parameters
    ----------
    x, y
        Place from the left and from the top over the picture's width and height [1].
    text
        Name and value.
    box
        Left, top, right and bottom of where a pointer is at the mark, as ``x`` and ``y`` are.
    """

    x: float
    y: float
    text: str
    box: Sequence[float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """An embedded picture of a page.

    Parameters
    ----------
    uri
        The picture as a ``data:`` URI.
    caption
        Text below the picture.
    alt
        Text for readers who cannot see the picture.
    panels
        Curves for the view that a script makes in place of the picture; none where empty.
    uri_for_phones
        The same picture for a page as narrow as a phone; none where empty.
    readable_width
        Least width at which the letters of what a phone shows can be read [pixel]; the picture scrolls where a phone is
        narrower.
    marks, marks_for_phones
        What a script tells at the pointer over the picture, and over that for phones; none where empty.
    """

    uri: str
    caption: str
    alt: str
    panels: Sequence[Panel] = ()
    uri_for_phones: str = ""
    readable_width: int = 0
    marks: Sequence[Mark] = ()
    marks_for_phones: Sequence[Mark] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A titled part of a page.

    Parameters
    ----------
    title
        Heading.
    anchor
        Target of links to the section; none where empty.
    paragraphs, pictures, tables
        Content, shown in this order.
    folded
        Whether the reader has to open the section.
    """

    title: str
    anchor: str = ""
    paragraphs: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()
    folded: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """A self-contained page.

    Parameters
    ----------
    title
        Heading of the page.
    lead
        Verdict, which a tired engineer reads first.
    sections
        Parts of the page in their order.
    synthetic
        True prints the label SYNTHETIC DATA, False says measured data, None says nothing (no data behind the page).
    footer
        Provenance: command, seed, versions.
    glance
        Table of the first screen, one line for each joint; None where there is none.
    others
        Other pages of the same results: what each is called, and its address.
    """

    title: str
    lead: str
    sections: Sequence[Section]
    synthetic: bool | None
    footer: Sequence[str] = ()
    glance: Table | None = None
    others: Sequence[tuple[str, str]] = ()

    @property
    def html(self) -> str:
        """The page as HTML."""
        pictures = [picture for section in self.sections for picture in section.pictures]
        answering = any(picture.panels or picture.marks for picture in pictures)
        scripts = [_asset(name) for name in SCRIPTS] if answering else []
        return _ENVIRONMENT.get_template("page.html.j2").render(
            page=self,
            words=_words_in(self._tables()),
            word_of=word_of,
            more_words=MORE_WORDS,
            inks=inks_css(),
            css=_asset("page.css") + (_asset("uPlot.min.css") if scripts else ""),
            scripts=scripts,
            policy=_policy(scripts),
        )

    def _tables(self) -> list[Table]:
        first = [] if self.glance is None else [self.glance]
        return first + [table for section in self.sections for table in section.tables]


def _words_in(tables: Iterable[Table]) -> list[Word]:
    """Return the words that the cells of some tables stand for, each once, in the order of their appearance."""
    keys: dict[str, None] = {}
    for table in tables:
        for row in table.rows:
            keys |= dict.fromkeys(cell.word for cell in row if isinstance(cell, Cell) and cell.word)
    return [word_of(key) for key in keys]


def _policy(scripts: Sequence[str]) -> str:
    """Return the policy by which a browser loads nothing from elsewhere, and runs no script but these."""
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii") for text in scripts]
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {allowed}"


@cache
def _asset(name: str) -> str:
    return (files("haptid.report.common") / name).read_text(encoding="utf-8").strip()


def _write_panels(panels: Sequence[Panel]) -> Markup:
    """Write panels as JSON in which no text can end the script that holds it."""
    return htmlsafe_json_dumps([asdict(panel) for panel in panels])


def _write_marks(picture: Picture) -> Markup:
    """Write the marks of a picture as JSON, those for a screen and those for a phone."""
    both = (picture.marks, picture.marks_for_phones or picture.marks)
    return htmlsafe_json_dumps([[(mark.x, mark.y, mark.text, mark.box) for mark in marks] for marks in both])


def _with_breaks(name: str) -> Markup:
    """Let the name of a file go on in the next line before a dot and after an underscore, and not within a word."""
    place = Markup("<wbr>")
    text = escape(name)
    return text.replace(".", place + ".").replace("_", "_" + place)


_ENVIRONMENT.filters["as_json"] = _write_panels
_ENVIRONMENT.filters["marks_as_json"] = _write_marks
_ENVIRONMENT.filters["with_breaks"] = _with_breaks
