"""What a reader of a page sees: text, tables, pictures, by the standard library's parser; and the figures behind it."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from html.parser import HTMLParser

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from haptid.report.common import page as pages
from haptid.report.common import style
from haptid.report.common.marks import Told
from haptid.report.common.page import Page

OWN_SCRIPTS = tuple(pages._asset(name) for name in pages.SCRIPTS)
VOID = {"meta", "img", "source", "br", "hr", "link", "input", "col", "wbr"}
SVG = b"<?xml"


@dataclass
class Grid:
    """A table of a page with the heading of its section."""

    section: str
    caption: str = ""
    rows: list[list[str]] = field(default_factory=list)

    @property
    def header(self) -> list[str]:
        return self.rows[0]

    def row(self, *first: str) -> dict[str, str]:
        """Return the cells by heading of the only row that begins with these texts; a second heading bears a prime."""
        (cells,) = [row for row in self.rows[1:] if tuple(row[: len(first)]) == first]
        headings: list[str] = []
        for heading in self.header:
            headings.append(f"{heading}'" if heading in headings else heading)
        return dict(zip(headings, cells, strict=True))

    def column(self, heading: str) -> list[str]:
        """Return the cells under a heading, from top to bottom."""
        return [row[self.header.index(heading)] for row in self.rows[1:]]


@dataclass
class Seen(HTMLParser):
    """Cells of tables by row, all text, tags, and pictures; a tag that is closed wrongly is an error."""

    tables: list[Grid] = field(default_factory=list)
    heading: str = ""
    paragraphs: list[str] = field(default_factory=list)
    captions: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    tags: set[str] = field(default_factory=set)
    pictures: list[bytes] = field(default_factory=list)
    alternatives: list[str] = field(default_factory=list)
    scripts: list[str] = field(default_factory=list)
    panels: list[list[dict]] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    targets: set[str] = field(default_factory=set)
    policy: str = ""
    may_break: bool = False
    open: list[str] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.may_break = tag == "wbr"
        given = dict(attrs)
        assert not [name for name in given if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "img":
            head, _, data = given["src"].partition(",")
            assert head == "data:image/svg+xml;base64"
            self.pictures.append(base64.b64decode(data, validate=True))
            self.alternatives.append(given["alt"])
        if tag == "script":
            self.scripts.append(given.get("type", ""))
        if tag == "a":
            self.links.append(given["href"])
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"]
        self.targets |= {given["id"]} if "id" in given else set()
        self._begin(tag)

    def _begin(self, tag):
        """Begin the empty text or table that the tag holds."""
        if tag in ("h2", "summary"):
            self.heading = ""
        if tag == "table":
            self.tables.append(Grid(self.heading))
        if tag == "p":
            self.paragraphs.append("")
        if tag == "figcaption":
            self.captions.append("")
        if tag == "tr":
            self.rows.append([])
            self.tables[-1].rows.append(self.rows[-1])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes another tag"

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self._read_script(data)
            return
        if self.open and self.open[-1] == "style":
            return
        # A place where a line may end parts no word.
        self.words.append(self.words.pop() + data if self.may_break else data)
        self.may_break = False
        if {"h2", "summary"} & set(self.open):
            self.heading += data
        if "caption" in self.open:
            self.tables[-1].caption += data
        if "p" in self.open:
            self.paragraphs[-1] += data
        if "figcaption" in self.open:
            self.captions[-1] += data
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data

    def _read_script(self, data):
        """Keep the panels of a picture; a script that runs is one of haptid's own."""
        if self.scripts[-1] == "application/json":
            self.panels.append(json.loads(data))
        else:
            assert self.scripts[-1] == ""
            assert data in OWN_SCRIPTS

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def table(self, section: str, caption: str = "", heading: str = "") -> Grid:
        """Return the only table of a section, of those with this in the caption and among the headings."""
        (found,) = [
            grid
            for grid in self.tables
            if grid.section == section and caption in grid.caption and heading in (*grid.header, "")
        ]
        return found

    def row(self, first: str) -> list[str]:
        """Return the cells of the first row that begins with this text."""
        return next(cells for cells in ([c.strip() for c in row] for row in self.rows) if cells and cells[0] == first)


def seen(page: str) -> Seen:
    """Parse a page, and check what every page keeps to."""
    parser = Seen()
    parser.feed(page)
    parser.close()
    assert parser.open == []
    assert page.lower().startswith("<!doctype html>")
    # Whatever a text of the user brought in, the browser would refuse to run or to load.
    assert parser.policy.startswith("default-src 'none'; img-src data:;")
    assert "unsafe" not in parser.policy.partition("script-src")[2]
    assert all(data.startswith(SVG) and len(data) > 2_000 and b"<script" not in data for data in parser.pictures)
    assert {link[1:] for link in parser.links if link.startswith("#")} <= parser.targets
    assert all(parser.alternatives)
    return parser


def render(make: Callable[..., Page], *arguments: object, **options: object) -> Seen:
    """Make a page and parse it; its figures are kept as they are drawn, and none of them is rendered."""
    drawn: list[Figure] = []

    def keep(figure: Figure) -> bytes:
        drawn.append(figure)
        return SVG + bytes(2_001)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "svg", keep)
        page = seen(make(*arguments, **options).html)
    page.figures = drawn
    return page


def heights(line) -> list[float]:
    """Return the ordinates of a drawn line, to six digits."""
    return [float(f"{y:.6g}") for y in line.get_ydata()]


def ends_of_band(axis) -> list[float]:
    """Return the lower and the upper end of the only horizontal band of an axis, to six digits."""
    (patch,) = axis.patches
    return [float(f"{y:.6g}") for y in (patch.get_y(), patch.get_y() + patch.get_height())]


def ends_of_area(area) -> list[float]:
    """Return the least and the largest ordinate of a filled area, to six digits."""
    ordinates = area.get_paths()[0].vertices[:, 1]
    return [float(f"{y:.6g}") for y in (ordinates.min(), ordinates.max())]


def told_in(axis: Axes) -> list[str]:
    """Return what a page tells at the marks of an axis."""
    return [told.text for told in axis.artists if isinstance(told, Told)]
