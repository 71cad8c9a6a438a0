"""Links between the pages of one folder of results: folder in, its pages written again where they lack a link.

A page of an identification lies at the top, as that of a posterior and of a locking plan; findings lie in a folder
below. Each is written when its stage ends, and so cannot know of the later ones.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from haptid.report.common.page import Page
from haptid.report.common.stored_page import content_of, read_page, write_page
from haptid.support.errors import InputError

TOP = {"report": "identification", "posterior": "posterior", "locking_plan": "locking plan"}
"""What a page at the top is called in a link, by the stem of its file."""
FINDINGS = "discrepancy"
"""Folder of findings and their pages."""
WHOLE = "whole"
"""Name of the finding of a check of all joints."""
NAME_OF_FINDING = re.compile(rf"joints?(\d+)|{WHOLE}")
"""Names of findings; a stage alone, as ``joint3_gap``, is none. The group holds the numbers of the joints."""


def link_pages(folder: Path) -> list[Path]:
    """Link each page of a folder of results with the others.

    Parameters
    ----------
    folder
        Folder of the results.

    Returns
    -------
    list of Path
        Pages that were written again; those without stored content stay as they are, and are linked to.

    Raises
    ------
    WritingError
        Where a page cannot be written.
    """
    titles = {folder / f"{stem}.html": title for stem, title in TOP.items()}
    titles |= {path: _title_of_finding(path) for path in sorted((folder / FINDINGS).glob("*.html"))}
    there = {path: title for path, title in titles.items() if path.is_file()}
    written = []
    for path in there:
        page = _stored(path)
        others = [(title, _href(other, path.parent)) for other, title in there.items() if other != path]
        if page is not None and list(page.others) != others:
            written.append(write_page(path, replace(page, others=others)))
    return written


def _stored(path: Path) -> Page | None:
    """Return the content of a page; None where it is not stored, or not as this version stores it."""
    if not content_of(path).exists():
        return None
    try:
        return read_page(path)
    except InputError:  # the page stays as it is; haptid report tells what is wrong with its content
        return None


def _href(path: Path, folder: Path) -> str:
    """Return the address of a page in a link of a page in ``folder``, which is its own, above or below."""
    if path.parent == folder:
        return path.name
    return f"../{path.name}" if path.parent == folder.parent else f"{path.parent.name}/{path.name}"


def _title_of_finding(path: Path) -> str:
    """Return what a finding is called in a link: ``missing in joint 4``, or in joints 0, 1."""
    name = NAME_OF_FINDING.fullmatch(path.stem)
    if name is None:
        return f"missing: {path.stem}"
    if name[1] is None:
        return "missing in the whole device"
    return f"missing in joint{'s' if path.stem.startswith('joints') else ''} {', '.join(name[1])}"
