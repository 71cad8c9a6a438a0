"""Markdown tables, and the parts of a page that a script writes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import click

from haptid.support.files.files import write_text
from haptid.support.installing.environment import ROOT


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(c).replace("|", "\\|") for c in line) + " |" for line in lines) + "\n"


def with_parts(page: str, parts: Mapping[str, str], script: str) -> str:
    """Return a page with its generated parts written anew.

    Parameters
    ----------
    page
        Markdown with a pair of comments around each part: ``<!-- NAME: made by SCRIPT -->``, ``<!-- end of NAME -->``.
    parts
        New texts by name.
    script
        Path of the script that writes them.

    Raises
    ------
    ValueError
        Where the page lacks the comments of a part.
    """
    for name, text in parts.items():
        begin, end = f"<!-- {name}: made by {script} -->", f"<!-- end of {name} -->"
        before, found, rest = page.partition(begin)
        _, closed, after = rest.partition(end)
        if not (found and closed):
            msg = f"the page lacks {begin} or {end}"
            raise ValueError(msg)
        page = f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}"
    return page


def parts_of(page: str) -> list[str]:
    """Return the names of the generated parts of a page."""
    return re.findall(r"<!-- end of ([^>]*) -->", page)


def page_command(page: Path, make: Callable[[str], str]) -> click.Command:
    """Return the command that writes the generated parts of a page anew.

    Parameters
    ----------
    page
        The page.
    make
        Turns its text into that with new parts.
    """

    @click.command(help=f"Write the generated parts of {page.relative_to(ROOT).as_posix()}.")
    def main() -> None:
        write_text(page, make(page.read_text(encoding="utf-8")))
        click.echo(page.relative_to(ROOT))

    return main
