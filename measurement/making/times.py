"""Read a time whose column does not say its unit, as dates or as bare numbers: `Table` in, `Table` with seconds out."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

import numpy as np
import pandas as pd

from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.units_in_names import QUANTITIES, understand_column
from haptid.measurement.tables.misnamed import TIME_UNITS, likely_time_units, looks_like_time
from haptid.measurement.tables.table import (
    DOTTED_DATE,
    ISO_DATE,
    SLASHED_DATE,
    TIME_OF_DAY,
    UNCERTAIN_DATE,
    WRITE_ISO,
    Table,
)
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

TIME = "time_s"
UNITS_OF_TIME = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
COUNTER = 2.0**32
"""Ticks after which a counter of 32 bits begins anew [1]."""
DAY_S = 86400.0
MILLENNIUM = pd.Timestamp("2000-01-01", tz="UTC")
"""Moment from which dates are counted before their first row is known."""
WHOLE_SECONDS = re.compile(r"(.*?)(?:secs?|seconds)", re.IGNORECASE)
NANOSECONDS = re.compile(r"(.*?)(?:nano?secs?|nsecs?|nanoseconds)", re.IGNORECASE)
"""Names of the two parts of a stamp, as ROS has them: ``header.stamp.sec`` and ``header.stamp.nanosec``."""


def with_seconds(table: Table, stated: Collection[str] = ()) -> tuple[Table, str]:
    """Return a table whose dates (with the time of day) or durations are seconds from its first row.

    Dates are read as ISO 8601 has them, with dots, where the day comes first, and with slashes after the year. Those of
    several time zones are counted in UTC, where one without a zone is taken to be. A time of day without a date may
    pass midnight. Whole seconds and nanoseconds in two columns, as stamps of ROS, are one time.

    Parameters
    ----------
    table
        The user's table, its cells as text, numbers, dates or durations.
    stated
        Columns that the user names by ``--map``, which keep their names.

    Returns
    -------
    table : Table
        The table itself where it has no time in dates, or a time besides. A cell that is no date stays as it is, so
        that the error of the later reading shows it.
    layout : str
        What was understood, in words; empty where nothing was.

    Raises
    ------
    InputError
        Where the order of day, month and year in the dates is not certain.
    """
    stamp = _parts_of_stamp(table, stated)
    if stamp:
        return _with_whole_stamp(table, *stamp)
    dated = [column for column in table.columns if _holds_dates(table.frame[column])]
    times = [column for column in dated if column in stated or column == TIME or is_time(column)]
    # Of several columns with dates only one with a time's name is the time.
    chosen = times or (dated if not any(is_time(column) for column in table.columns) else [])
    if len(chosen) != 1:
        return table, ""
    (column,) = chosen
    cells = table.frame[column]
    first = _first_filled(cells)
    if first is None:
        return table, ""
    if isinstance(first, timedelta | np.timedelta64):
        since = pd.to_timedelta(cells, errors="coerce")
    else:
        cells = _in_iso(cells)
        _refuse_uncertain(table, column, cells)
        since = pd.to_datetime(cells, format="ISO8601", utc=True, errors="coerce") - MILLENNIUM
    if since.notna().sum() == 0:
        return table, ""
    seconds = (since - since.dropna().iloc[0]).dt.total_seconds()
    if isinstance(first, str) and TIME_OF_DAY.fullmatch(first):
        seconds = seconds + DAY_S * (seconds.diff() < -DAY_S / 2).cumsum()
    seconds = seconds.astype(object)
    seconds = seconds.where(since.notna(), cells.astype(object))
    name = column if column in stated else TIME
    frame = table.frame.assign(**{column: seconds}).rename(columns={column: name})
    return replace(table, frame=frame), f"dates in {column!r}, read as seconds from the first row"


@dataclass(frozen=True, slots=True, kw_only=True)
class AssumedTime:
    """A time whose unit the interval of its rows tells.

    Parameters
    ----------
    column
        The user's name of it.
    unit
        Symbol of the unit.
    seconds
        Seconds of one of it, as they are written.
    """

    column: str
    unit: str
    seconds: str

    @property
    def words(self) -> str:
        """The unit in words."""
        return UNITS_OF_TIME[self.unit]

    @property
    def other(self) -> str:
        """What says another unit, for an option ``--map``."""
        (unit, seconds), *_ = [one for one in TIME_UNITS if one[0] != self.unit]
        name = TIME if float(seconds) == 1.0 else f"{TIME}*{seconds}"
        return f"in {UNITS_OF_TIME[unit]}: --map '{self.column}={name}'"


def assume_time(table: Table, stated: Mapping[str, Target]) -> tuple[Table, AssumedTime | None]:
    """Read a time without a unit in the only one in which its rows are as far apart as those of a joint may be.

    Parameters
    ----------
    table
        The user's table.
    stated
        Column of the format by column of the user's table, as the user states it.

    Returns
    -------
    table : Table
        With a time in seconds; the table itself where it has another time, several of that kind, or one that may be in
        several units.
    assumed : AssumedTime or None
        None where nothing was assumed.
    """
    known = {target.name for target in stated.values()}
    known |= {target.name for column in table.columns if (target := understand_column(column, 1.0)) is not None}
    bare = [column for column in table.columns if is_bare_time(column) and column not in stated]
    if TIME in known or TIME in table.columns or len(bare) != 1:
        return table, None
    (column,) = bare
    t = table.loosely(column)
    found = _only_unit(t)
    if found is None:
        return table, None
    unit, seconds = found
    frame = table.frame
    if float(seconds) != 1.0:
        # A cell that is no number stays as it is, so that the error of the later reading shows it.
        converted = pd.Series(t * float(seconds), index=frame.index).astype(object)
        frame = frame.assign(**{column: converted.where(np.isfinite(t), frame[column].astype(object))})
    assumed = AssumedTime(column=column, unit=unit, seconds=seconds)
    return replace(table, frame=frame.rename(columns={column: TIME})), assumed


def is_bare_time(column: str) -> bool:
    """Whether a name is that of a time, without a unit.

    Parameters
    ----------
    column
        Name of a column.

    Returns
    -------
    bool
    """
    words = re.findall(r"[^\W_]+", column.lower())
    return bool(words) and all(QUANTITIES.get(word) == "time" for word in words)


def _only_unit(t: Array) -> tuple[str, str] | None:
    """Return the unit that the interval of the rows tells, with its seconds; None where it may be several, or none."""
    intervals = np.diff(t[np.isfinite(t)])
    if intervals.size == 0 or np.any(intervals < 0.0):
        return None
    usual = float(np.median(intervals))
    if THRESHOLDS.shortest_likely_row_interval_s <= usual <= THRESHOLDS.longest_usual_row_interval_s:
        return TIME_UNITS[0]
    likely = likely_time_units(usual)
    return likely[0] if len(likely) == 1 else None


def with_counter_counted_on(table: Table, targets: Mapping[str, Target]) -> tuple[Table, str]:
    """Count the time on where a counter of 32 bits began anew, as that of microseconds does after 71 minutes.

    Parameters
    ----------
    table
        The user's table, its cells as text or as numbers.
    targets
        Column of the format by column of the user's table.

    Returns
    -------
    table : Table
        The table itself where no whole number of ticks falls by 2³² but for an interval as long as others.
    remark : str
        What was done; empty where nothing was.
    """
    column = next((column for column, target in targets.items() if target.name == TIME and target.factor < 1.0), None)
    if column is None:
        return table, ""
    ticks = table.loosely(column)
    if not np.isfinite(ticks).all() or np.any(ticks != np.round(ticks)):
        return table, ""
    steps = np.diff(ticks)
    wraps = steps < 0.0
    usual = THRESHOLDS.longest_interval_at_counter_wrap * float(np.median(steps, axis=0)) if steps.size else 0.0
    if not wraps.any() or np.any((steps[wraps] + COUNTER <= 0.0) | (steps[wraps] + COUNTER > usual)):
        return table, ""
    counted = ticks + COUNTER * np.concatenate([[0.0], np.cumsum(wraps)])
    return replace(table, frame=table.frame.assign(**{column: counted})), f"{column} began anew at 2³², counted on"


def has_time(table: Table, stated: Mapping[str, Target]) -> bool:
    """Whether a table has a column that holds the time, or is likely to.

    Parameters
    ----------
    table
        The user's table.
    stated
        Column of the format by column of the user's table, as the user states it.

    Returns
    -------
    bool
    """
    return any(target.name == TIME for target in stated.values()) or any(is_time(column) for column in table.columns)


def is_time(column: str) -> bool:
    """Whether a name is that of a time, with or without a unit.

    Parameters
    ----------
    column
        Name of a column.

    Returns
    -------
    bool
    """
    target = understand_column(column, 1.0)
    return column == TIME or (target is not None and target.name == TIME) or looks_like_time(column)


def _parts_of_stamp(table: Table, stated: Collection[str]) -> tuple[str, str] | None:
    """Return the columns with whole seconds and nanoseconds of the only time of a table; None where there are none."""
    fine = {found[1]: column for column in table.columns if (found := NANOSECONDS.fullmatch(column))}
    whole = {found[1]: column for column in table.columns if (found := WHOLE_SECONDS.fullmatch(column))}
    pairs = [(whole[stem], fine[stem]) for stem in whole if stem in fine]
    others = [column for column in table.columns if is_time(column) and all(column not in pair for pair in pairs)]
    if len(pairs) != 1 or others or any(column in stated for column in pairs[0]):
        return None
    return pairs[0]


def _with_whole_stamp(table: Table, whole: str, fine: str) -> tuple[Table, str]:
    """Return a table with the seconds of a stamp from its first row, in place of their two parts."""
    seconds, nanoseconds = table.loosely(whole), table.loosely(fine)
    first = int(np.argmax(np.isfinite(seconds + nanoseconds)))
    stamp = (seconds - seconds[first]) + 1e-9 * (nanoseconds - nanoseconds[first])
    frame = table.frame.assign(**{whole: stamp}).rename(columns={whole: TIME}).drop(columns=fine)
    return replace(table, frame=frame), f"{whole!r} and {fine!r}, read as seconds from the first row"


def _first_filled(cells: pd.Series) -> object:
    """Return the first cell that is not empty; None where all are."""
    filled = cells.dropna()
    return filled.iloc[0] if len(filled) else None


def _holds_dates(cells: pd.Series) -> bool:
    """Whether the first filled cell is a date with the time of day, or a duration."""
    if pd.api.types.is_datetime64_any_dtype(cells.dtype) or pd.api.types.is_timedelta64_dtype(cells.dtype):
        return True
    return _is_date(_first_filled(cells))


def _is_date(cell: object) -> bool:
    if isinstance(cell, datetime | np.datetime64 | timedelta | np.timedelta64):  # of several time zones, for example
        return True
    forms = (ISO_DATE, DOTTED_DATE, SLASHED_DATE, UNCERTAIN_DATE, TIME_OF_DAY)
    return isinstance(cell, str) and any(form.fullmatch(cell) for form in forms)


def _in_iso(cells: pd.Series) -> pd.Series:
    """Write dates with dots, or slashes after the year, and times of day as ISO 8601 has them; leave other cells."""
    if pd.api.types.is_datetime64_any_dtype(cells.dtype):
        return cells
    return cells.map(_date_in_iso, na_action="ignore")


def _date_in_iso(cell: object) -> object:
    if not isinstance(cell, str):
        return cell
    if found := DOTTED_DATE.fullmatch(cell):
        day, month, year, time = found.groups()
    elif found := SLASHED_DATE.fullmatch(cell):
        year, month, day, time = found.groups()
    elif TIME_OF_DAY.fullmatch(cell):
        year, month, day, time = "2000", "1", "1", cell.strip()
    else:
        return cell
    hour, _, rest = time.partition(":")
    return f"{year}-{month:0>2}-{day:0>2}T{hour:0>2}:{rest.replace(',', '.')}"


def _refuse_uncertain(table: Table, column: str, cells: pd.Series) -> None:
    """Refuse a time in dates where the first of them may be of several days."""
    index = int(np.flatnonzero(cells.notna().to_numpy())[0])
    cell = cells.iloc[index]
    if isinstance(cell, str) and UNCERTAIN_DATE.fullmatch(cell):
        where = f"{table.row(index)}, {column}"
        raise InputError(where, expected="a date of one day", got=repr(cell), todo=WRITE_ISO)
