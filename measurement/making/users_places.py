"""Places in the tables of a draft in, the places in the user's own files out: no error may name a file of a draft."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from haptid.measurement.making.prepared import PreparedTable

PLACE = re.compile(r"(?:, (?P<unit>line|row) (?P<number>\d+)|(?P<columns>, columns))?(?=$|,)")
"""What follows the name of a table in the place of an error, as `Table` writes it."""


def name_users_places(where: str, draft: Path, folder: Path, prepared: Sequence[PreparedTable]) -> str:
    """Name a place in a draft as one in the user's files.

    Parameters
    ----------
    where
        Place of an error.
    draft
        Folder of the draft.
    folder
        Folder of the user's tables.
    prepared
        Tables of the draft.

    Returns
    -------
    str
        File, and line or row of it; with the user's folder for the draft's where it is in no table.
    """
    for one in prepared:
        written = str(draft / one.file)
        found = PLACE.match(where, len(written)) if where.startswith(written) else None
        if found is not None:
            return f"{_place_in_source(one, found)}{where[found.end() :]}".replace(str(draft), str(folder))
    return where.replace(str(draft), str(folder))


def _place_in_source(one: PreparedTable, found: re.Match[str]) -> str:
    """Return a place in the table that one was made of."""
    if found["number"] is None:
        return one.source.header if found["columns"] else str(one.source.path)
    # The first line of a table in a draft is its header.
    row = int(found["number"]) - (2 if found["unit"] == "line" else 1)
    return one.source.row(row) if 0 <= row < len(one.frame) else one.source.header
