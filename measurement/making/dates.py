"""Read a time that is written as dates: `Table` in, `Table` with seconds from its first row out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import pandas as pd

from haptid.measurement.making.units_in_names import understand_column
from haptid.measurement.tables.misnamed import looks_like_time
from haptid.measurement.tables.table import ISO_DATE, Table

TIME = "time_s"


def with_seconds(table: Table, stated: Collection[str] = ()) -> tuple[Table, str]:
    """Return a table whose dates (ISO 8601, with the time of day) are seconds from its first row.

    Parameters
    ----------
    table
        The user's table, its cells as text, numbers or dates.
    stated
        Columns that the user names by ``--map``, which keep their names.

    Returns
    -------
    table : Table
        The table itself where it has no time in dates, or a time besides. A cell that is no date stays as it is, so
        that the error of the later reading shows it.
    layout : str
        What was understood, in words; empty where nothing was.
    """
    dated = [column for column in table.columns if _holds_dates(table.frame[column])]
    times = [column for column in dated if column in stated or column == TIME or _is_time(column)]
    # Of several columns with dates only one with a time's name is the time.
    chosen = times or (dated if not any(_is_time(column) for column in table.columns) else [])
    if len(chosen) != 1:
        return table, ""
    (column,) = chosen
    cells = table.frame[column]
    moments = pd.to_datetime(cells, format="ISO8601", utc=True, errors="coerce")
    if moments.notna().sum() == 0:
        return table, ""
    seconds = (moments - moments.dropna().iloc[0]).dt.total_seconds().astype(object)
    seconds = seconds.where(moments.notna(), cells.astype(object))
    name = column if column in stated else TIME
    frame = table.frame.assign(**{column: seconds}).rename(columns={column: name})
    return replace(table, frame=frame), f"dates in {column!r}, read as seconds from the first row"


def _is_time(column: str) -> bool:
    target = understand_column(column, 1.0)
    return column == TIME or (target is not None and target.name == TIME) or looks_like_time(column)


def _holds_dates(cells: pd.Series) -> bool:
    """Whether the first filled cell is a date with the time of day."""
    if pd.api.types.is_datetime64_any_dtype(cells.dtype):
        return True
    filled = cells.dropna()
    return len(filled) > 0 and isinstance(filled.iloc[0], str) and ISO_DATE.fullmatch(filled.iloc[0]) is not None
