"""Refuse columns whose numbers have a sign between thousands: one such sign is read as that of decimals."""

from __future__ import annotations

import re

import pandas as pd

from haptid.measurement.tables.table import Table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.support.errors import InputError

PARTED = re.compile(r"\s*[+-]?[1-9]\d{0,2}[.,]\d{3}\s*")
"""A number from 1000 on with its sign between thousands, or one with three decimals."""
BELOW = re.compile(r"\s*[+-]?\d{1,3}\s*")
"""A whole number below 1000."""
CELLS = 20_000
"""Cells of a column that are looked at, spread over all its rows."""


def refuse_thousands(table: Table) -> None:
    """Refuse a table with a column of whole numbers, of which those from 1000 on have a sign between thousands.

    Parameters
    ----------
    table
        The user's table, its cells as text.

    Raises
    ------
    InputError
        Where all cells of a column are whole numbers below 1000 or have exactly three digits behind one point, both
        kinds are there, and so many of the latter that decimals would end in a zero somewhere, which is left out where
        the point is.
    """
    for column in table.columns:
        cells = table.frame[column]
        if not pd.api.types.is_string_dtype(cells.dtype):
            continue
        seen = cells.iloc[:: max(len(cells) // CELLS, 1)].dropna().astype(str)
        parted = seen[seen.str.fullmatch(PARTED)]
        if len(parted) < THRESHOLDS.least_cells_of_thousands:
            continue
        below = seen[seen.str.fullmatch(BELOW)]
        if len(below) and len(parted) + len(below) == len(seen):
            got = f"{parted.iloc[0].strip()!r} beside {below.iloc[0].strip()!r}, and never one or two decimals"
            todo = "export it without a sign between thousands"
            where = f"{table.header}, {column}"
            raise InputError(where, expected="numbers", got=got, todo=todo)
