"""Examine built pages in a browser: axe-core's violations on a wide screen and on a phone, in light and dark colours.

``python -m docs.accessibility artifacts/docs`` examines all pages; the tests examine one of each kind. It needs the
dependencies of development and a Chromium on the path.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import click

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
WIDTHS = (1280, 390)
"""Widths of a screen and of a phone [px]."""
Scheme = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = get_args(Scheme)
HEIGHT = 900
"""Height of both [px]; axe looks at the whole page."""


class Violation(NamedTuple):
    """A rule that a page breaks.

    Parameters
    ----------
    page
        Name of the file.
    width, scheme
        Width [px] and colours in which it does.
    rule
        Id of axe's rule.
    nodes
        Number of elements that break it.
    example
        The first of them.
    """

    page: str
    width: int
    scheme: Scheme
    rule: str
    nodes: int
    example: str


def find_browser() -> str | None:
    """Return the path of a Chromium; None where there is none."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def examine_pages(
    pages: Sequence[Path], views: Sequence[tuple[int, Scheme]], browser: str | None = None
) -> Iterator[list[Violation]]:
    """Open pages in a browser and let axe-core examine them.

    Parameters
    ----------
    pages
        HTML files.
    views
        Widths [px] and colours in which each is opened.
    browser
        Path of a Chromium; None to find one.

    Yields
    ------
    list of Violation
        Those of one page in one view.
    """
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415 (a dependency of development)
    from playwright.sync_api import sync_playwright  # noqa: PLC0415

    with sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=browser or find_browser(), args=["--no-sandbox"])
        for width, scheme in views:
            context: Any = opened.new_context(viewport={"width": width, "height": HEIGHT}, color_scheme=scheme)
            shown = context.new_page()
            for page in pages:
                shown.goto(page.as_uri())
                yield [
                    Violation(page.name, width, scheme, one["id"], len(one["nodes"]), one["nodes"][0]["html"])
                    for one in Axe().run(shown).response["violations"]
                ]
            context.close()
        opened.close()


@click.command()
@click.argument("site", type=click.Path(path_type=Path, exists=True, file_okay=False), default=Path("artifacts/docs"))
def main(site: Path) -> None:
    """Let axe-core examine all pages below SITE; exit code 1 where it finds a violation."""
    pages = sorted(site.rglob("*.html"))
    views = [(width, scheme) for width in WIDTHS for scheme in SCHEMES]
    found = [violation for part in examine_pages(pages, views) for violation in part]
    for one in found:
        click.echo(f"{one.page} ({one.width} px, {one.scheme}): {one.rule}, {one.nodes} times, as {one.example[:120]}")
    click.echo(f"{len(pages)} pages, {len(views)} views each: {len(found)} violations")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
