"""The page of all reports: `Page` of `Section`s in, self-contained HTML out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jinja2

_ENVIRONMENT = jinja2.Environment(
    loader=jinja2.PackageLoader("haptid.report.common", ""),
    autoescape=True,  # titles and names of files come from users
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,  # a misspelt name in the template is an error, not a gap in the page
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table of a page.

    Parameters
    ----------
    header
        Texts of the header cells.
    rows
        Texts of the cells, row by row.
    caption
        Text above the table; none where empty.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""


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
    """

    uri: str
    caption: str
    alt: str


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
    """

    title: str
    lead: str
    sections: Sequence[Section]
    synthetic: bool | None
    footer: Sequence[str] = ()

    @property
    def html(self) -> str:
        """The page as HTML."""
        return _ENVIRONMENT.get_template("page.html.j2").render(
            title=self.title, lead=self.lead, sections=self.sections, synthetic=self.synthetic, footer=self.footer
        )
