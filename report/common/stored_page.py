"""Pages on disk: HTML, and beside it the content from which the HTML can be written again without any computation.

The content of ``report.html`` is ``pages/report.json.gz`` in the same folder: titles, sentences, tables and pictures.
"""

from __future__ import annotations

import gzip
import io
import json
import zlib
from dataclasses import asdict
from pathlib import Path
from typing import Any

from haptid.report.common.page import Cell, Curve, Fill, Mark, Numbers, Page, Panel, Picture, Section, Table
from haptid.report.common.words import WORDS
from haptid.support.errors import InputError
from haptid.support.files.files import read_content, write_bytes, write_text

FOLDER, SUFFIX = "pages", ".json.gz"
SCHEMA = "page/1"
WANTED = "the content of a page that haptid wrote"
WIDTH_OF_LARGE_PICTURES = 704
"""Width at which a picture of 8.5 inch can be read, for pages that do not state it [pixel]."""
LARGEST_CONTENT = 500_000_000
"""Most bytes of an unpacked content; the page of a campaign of 500 runs has a tenth of them."""


def write_page(path: Path, page: Page) -> Path:
    """Write a page and its content.

    Parameters
    ----------
    path
        The HTML file; its content goes into the folder ``pages`` beside it.
    page
        Page to write.

    Returns
    -------
    Path
        ``path``.
    """
    text = json.dumps({"schema": SCHEMA, **asdict(page)}, default=list, ensure_ascii=False)
    # The page first: on a disk that is full, the user hears of the page.
    write_text(path, page.html)
    # Without the date of writing, the same page gives the same bytes.
    write_bytes(content_of(path), gzip.compress(text.encode(errors="replace"), mtime=0))
    return path


def content_of(path: Path) -> Path:
    """Return the file with the content of the page at ``path``.

    Parameters
    ----------
    path
        The HTML file of the page.

    Returns
    -------
    Path
        File in the folder ``pages`` beside it.
    """
    return path.parent / FOLDER / f"{path.stem}{SUFFIX}"


def read_page(path: Path) -> Page:
    """Read the content of a page.

    Parameters
    ----------
    path
        The HTML file, which need not exist.

    Returns
    -------
    Page
        The page as it was written.

    Raises
    ------
    InputError
        Where its content cannot be read, or is none that `write_page` wrote.
    """
    source = content_of(path)
    packed = read_content(source, WANTED)
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(packed)) as stream:
            return _page_from(json.loads(stream.read(LARGEST_CONTENT)))
    except (OSError, EOFError, zlib.error, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(str(source), expected=WANTED, got=f"{type(error).__name__}: {error}") from None


def _page_from(data: dict[str, Any]) -> Page:
    if data["schema"] != SCHEMA:
        msg = f"schema {data['schema']!r}"
        raise ValueError(msg)
    return Page(
        title=data["title"],
        lead=data["lead"],
        sections=[_section_from(section) for section in data["sections"]],
        synthetic=data["synthetic"],
        footer=data["footer"],
        glance=_table_from(data["glance"]) if data.get("glance") else None,
        others=[(title, address) for title, address in data.get("others", ())],
    )


def _section_from(data: dict[str, Any]) -> Section:
    pictures = [_picture_from(picture) for picture in data["pictures"]]
    for picture in pictures:
        uris = [uri for uri in (picture.uri, picture.uri_for_phones) if uri]
        if not uris or not all(uri.startswith("data:image/") for uri in uris):  # a page needs nothing from elsewhere
            msg = "a picture that is not part of the page"
            raise ValueError(msg)
    return Section(
        title=data["title"],
        anchor=data["anchor"],
        paragraphs=data["paragraphs"],
        pictures=pictures,
        tables=[_table_from(table) for table in data["tables"]],
        folded=data["folded"],
    )


def _picture_from(data: dict[str, Any]) -> Picture:
    panels = [_panel_from(panel) for panel in data.get("panels", ())]
    marks: dict[str, Any] = {
        name: [Mark(**mark) for mark in data[name]] for name in ("marks", "marks_for_phones") if name in data
    }
    if "small" in data:  # pages of November 2026 have this in place of a width
        known = {name: value for name, value in data.items() if name != "small"}
        return Picture(**{**known, "panels": panels, "readable_width": 0 if data["small"] else WIDTH_OF_LARGE_PICTURES})
    return Picture(**{**data, **marks, "panels": panels})


def _panel_from(data: dict[str, Any]) -> Panel:
    curves = [Curve(**_with_numbers(curve, "x", "y")) for curve in data["curves"]]
    fills = [Fill(**_with_numbers(fill, "low", "high")) for fill in data["fills"]]
    return Panel(**{**data, "curves": curves, "fills": fills})


def _with_numbers(data: dict[str, Any], *names: str) -> dict[str, Any]:
    return {**data, **{name: Numbers(**data[name]) for name in names}}


def _table_from(data: dict[str, Any]) -> Table:
    rows = [[Cell(**cell) if isinstance(cell, dict) else cell for cell in row] for row in data["rows"]]
    for cell in (cell for row in rows for cell in row if isinstance(cell, Cell)):
        if cell.word and cell.word not in WORDS:
            msg = f"word {cell.word!r}"
            raise ValueError(msg)
    return Table(**{**data, "rows": rows})
