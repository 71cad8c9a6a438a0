"""What a reader of a page sees: text, tables, pictures, by the standard library's parser."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "img", "br", "hr", "link", "input", "col", "wbr"}
PNG = b"\x89PNG\r\n\x1a\n"


@dataclass
class Seen(HTMLParser):
    """Cells of tables by row, all text, tags, and pictures; a tag that is closed wrongly is an error."""

    rows: list[list[str]] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    tags: set[str] = field(default_factory=set)
    pictures: list[bytes] = field(default_factory=list)
    alternatives: list[str] = field(default_factory=list)
    open: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        given = dict(attrs)
        assert not [name for name in given if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag == "img":
            head, _, data = given["src"].partition(",")
            assert head == "data:image/png;base64"
            self.pictures.append(base64.b64decode(data, validate=True))
            self.alternatives.append(given["alt"])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes another tag"

    def handle_data(self, data):
        self.words.append(data)
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

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
    assert "script" not in parser.tags
    assert all(data.startswith(PNG) and len(data) > 2_000 for data in parser.pictures)
    assert all(parser.alternatives)
    return parser
