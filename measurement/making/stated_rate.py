"""Count the time of a table without one by the rate that a line before its header states: `Table` in and out."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from haptid.measurement.making.times import TIME, has_time
from haptid.measurement.naming.mapping import Target
from haptid.measurement.naming.signal_names import COUNTS_ROWS
from haptid.measurement.naming.units import UNITS, respell
from haptid.measurement.tables.table import Table
from haptid.measurement.thresholds import THRESHOLDS

HERTZ = {"hz": 1.0, "khz": 1e3, "1/s": 1.0, "s/s": 1.0, "sps": 1.0, "samples/s": 1.0, "": 1.0}
"""Rows of a second by the unit of a rate."""
SECONDS = {"": 1.0, **{unit: seconds for unit, (base, seconds) in UNITS.items() if base == "s"}}
"""Seconds by the unit of an interval."""
NUMBER = r"(?P<number>\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)"
LINE = (
    r"\W*(?:{words})\s*(?:[\[(]\s*(?P<before>[^\])]*?)\s*[\])])?[\s:=;,\"]*{number}\s*[\[(\"]?(?P<after>[a-zµ/1]*)\W*"
)
TAKEN = r"(?:sampl(?:e|ing)|scan(?:ning)?|log(?:ging)?|record(?:ing)?|acquisition|data)[\s_-]*"
RATE = re.compile(
    LINE.format(
        words=rf"{TAKEN}(?:rate|frequency|freq)|fs|f_s|abtast(?:rate|frequenz)|messrate|messfrequenz", number=NUMBER
    ),
    re.IGNORECASE,
)
"""A line that states how many rows a second has, as ``# Sampling rate: 250 Hz``."""
INTERVAL = re.compile(
    LINE.format(words=rf"{TAKEN}(?:time|period|interval|step)|dt|abtast(?:zeit|intervall|periode)", number=NUMBER),
    re.IGNORECASE,
)
"""A line that states how long it is from row to row, as ``dt = 4 ms``."""


def with_time_of_rate(table: Table, stated: Mapping[str, Target]) -> tuple[Table, str]:
    """Give a table without a time the time ``n·dt`` of its rows, where a line before the header states the rate.

    Parameters
    ----------
    table
        The user's table, with the lines before its header.
    stated
        Column of the format by column of the user's table, as the user states it.

    Returns
    -------
    table : Table
        The table itself where it has a time, no line states a rate, or several lines differ. A column that counts the
        rows becomes the time, so that a row that is missing is missed.
    told : str
        What was understood, in words; empty where nothing was.
    """
    if has_time(table, stated):
        return table, ""
    found = {interval: line for line in table.preamble for interval in _intervals_in(line)}
    if len(found) != 1:
        return table, ""
    ((interval, line),) = found.items()
    counters = [column for column in table.columns if column not in stated and COUNTS_ROWS.search(column)]
    counter = next((column for column in counters if _counts(table, column)), "")
    n = table.loosely(counter) if counter else np.arange(len(table.frame), dtype=float)
    frame = table.frame.drop(columns=[counter] if counter else [])
    frame.insert(0, TIME, (n - n[0]) * interval)
    whose = f"{counter!r} as the number of the row" if counter else "no time"
    return replace(table, frame=frame), f"{whose}; rows {interval:.6g} s apart as {line!r} says"


def _counts(table: Table, column: str) -> bool:
    """Whether a column counts on by whole numbers."""
    steps = np.diff(table.loosely(column))
    return steps.size > 0 and bool(np.all((steps >= 1.0) & (steps == np.round(steps))))


def _intervals_in(line: str) -> Iterator[float]:
    """Yield how long it is from row to row [s], where a line states it or its inverse."""
    text = line.strip("#%;, \t")
    for pattern, units in ((RATE, HERTZ), (INTERVAL, SECONDS)):
        said = pattern.fullmatch(text)
        if said is None:
            continue
        unit = respell(said["before"] or said["after"] or "").strip().lower()
        value = float(said["number"].replace(",", "."))
        if unit not in units or value == 0.0:
            continue
        interval = 1.0 / (value * units[unit]) if pattern is RATE else value * units[unit]
        if THRESHOLDS.shortest_likely_row_interval_s <= interval <= THRESHOLDS.longest_row_interval_s:
            yield interval
