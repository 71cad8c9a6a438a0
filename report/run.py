"""``python -m report.run [RESULTS]``: the pages of stored results again, without fitting."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.report.commands import report as main
from haptid.report.common.linked_pages import FINDINGS
from haptid.report.common.stored_page import FOLDER, SUFFIX, content_of, read_page
from haptid.report.from_json.page import page_from_json
from haptid.support.errors import InputError
from haptid.support.files.files import read_json, write_text

MAKERS = {
    "identification.json": ("report.html", "haptid identify"),
    "posterior.json": ("posterior.html", "haptid posterior"),
    "locking_plan.json": ("locking_plan.html", "haptid plan"),
}
"""Page and command of each result that lies at the top of a folder."""


def render_again(results: Path) -> dict[str, Any]:
    """Write the pages of stored results again, and tell which.

    Parameters
    ----------
    results
        Folder of the results.

    Returns
    -------
    dict
        Paths of the pages under ``pages``, and of the results without stored page under ``without_content``.

    Raises
    ------
    InputError
        Where the folder holds no result.
    """
    if not results.is_dir():
        raise InputError(str(results), expected="a folder of results", got="no such folder")
    pages = _stored_pages(results)
    lacking = [one for one in _made_by(results) if not content_of(one[1]).exists()]
    if not pages and not lacking:
        todo = "name the --out of an earlier command"
        raise InputError(str(results), expected="results of haptid", got="none", todo=todo)
    for page in pages:
        write_text(page, read_page(page).html)
        click.echo(f"written: {page}")
    for data, page, maker in lacking:
        _write_plain(data, page, maker)
    return {"pages": [str(page) for page in pages], "without_content": [str(data) for data, _, _ in lacking]}


def _write_plain(data: Path, page: Path, maker: str) -> None:
    """Write a page of tables for a result without stored page, unless a page is there, which may have pictures."""
    if not page.exists() and data.name != "locking_plan.json":
        write_text(page, page_from_json(read_json(data, "a result"), str(data)).html)
        click.echo(f"written without pictures: {page}")
    click.echo(f"note: {data} has no stored page; {maker} makes it", err=True)


def _stored_pages(results: Path) -> list[Path]:
    """Return the pages whose content is stored."""
    contents = [path for folder in (results, results / FINDINGS) for path in (folder / FOLDER).glob(f"*{SUFFIX}")]
    return [path.parent.parent / f"{path.name.removesuffix(SUFFIX)}.html" for path in sorted(contents)]


def _made_by(results: Path) -> list[tuple[Path, Path, str]]:
    """Return each result that is there, its page, and the command that makes it."""
    made = [(results / data, results / page, maker) for data, (page, maker) in MAKERS.items()]
    found = sorted((results / FINDINGS).glob("joint*.json"))
    # A stage alone, as in joint4_gap.json, has a picture and no page.
    made += [(data, data.with_suffix(".html"), "haptid missing") for data in found if "_" not in data.stem]
    return [one for one in made if one[0].is_file()]


if __name__ == "__main__":
    main()
