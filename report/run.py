"""``python -m report.run [RESULTS]``: the pages of stored results again, without fitting."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from haptid.report.commands import report as main
from haptid.report.common.stored_page import FOLDER, SUFFIX, content_of, read_page
from haptid.support.errors import InputError
from haptid.support.files.files import write_text

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
        Where the folder holds no page that can be written.
    """
    if not results.is_dir():
        raise InputError(str(results), expected="a folder of results", got="no such folder")
    pages = _stored_pages(results)
    lacking = [(data, maker) for data, page, maker in _made_by(results) if not content_of(page).exists()]
    if not pages:
        todo = f"make its page by {lacking[0][1]}" if lacking else "name the --out of an earlier command"
        got = f"{lacking[0][0].name} without one" if lacking else "none"
        raise InputError(str(results), expected="results with stored pages", got=got, todo=todo)
    for page in pages:
        write_text(page, read_page(page).html)
        click.echo(f"written: {page}")
    for data, maker in lacking:
        click.echo(f"note: {data} has no stored page; {maker} makes it", err=True)
    return {"pages": [str(page) for page in pages], "without_content": [str(data) for data, _ in lacking]}


def _stored_pages(results: Path) -> list[Path]:
    """Return the pages whose content is stored."""
    contents = [path for folder in (results, results / "discrepancy") for path in (folder / FOLDER).glob(f"*{SUFFIX}")]
    return [path.parent.parent / f"{path.name.removesuffix(SUFFIX)}.html" for path in sorted(contents)]


def _made_by(results: Path) -> list[tuple[Path, Path, str]]:
    """Return each result that is there, its page, and the command that makes it."""
    made = [(results / data, results / page, maker) for data, (page, maker) in MAKERS.items()]
    found = sorted((results / "discrepancy").glob("joint*.json"))
    # A stage alone, as in joint4_gap.json, has a picture and no page.
    made += [(data, data.with_suffix(".html"), "haptid missing") for data in found if "_" not in data.stem]
    return [one for one in made if one[0].is_file()]


if __name__ == "__main__":
    main()
