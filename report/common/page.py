"""The page that all reports share: self-contained HTML from a list of sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jinja2
from markupsafe import Markup

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("haptid.report.common", ""),
    autoescape=True,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table: header cells and rows of text. Cells that are `Markup` are not escaped."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """An embedded picture: a ``data:`` URI, its caption, and the text for those who cannot see it."""

    uri: str
    caption: str
    alt: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A titled part of a page: paragraphs, pictures, tables, in this order. ``anchor`` makes it a link target."""

    title: str
    anchor: str = ""
    paragraphs: Sequence[str | Markup] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()
    folded: bool = False


def render_page(
    *, title: str, lead: str, sections: Sequence[Section], synthetic: bool | None, footer: Sequence[str] = ()
) -> str:
    """Render a page.

    Parameters
    ----------
    lead
        The verdict: what a tired engineer reads first.
    synthetic
        True prints the label SYNTHETIC DATA, False says measured data, None says nothing (no data behind the page).
    footer
        Provenance: command, seed, versions.
    """
    return _ENVIRONMENT.get_template("page.html.j2").render(
        title=title, lead=lead, sections=sections, synthetic=synthetic, footer=footer
    )
