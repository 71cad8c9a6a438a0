"""Find the column that holds a missing signal under another name or in another unit: names in, a remedy out."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import get_close_matches

from haptid.measurement.thresholds import THRESHOLDS

TIME_UNITS = (("s", "1"), ("ms", "0.001"), ("us", "1e-06"), ("ns", "1e-09"))
"""Units that a time may be in, and the seconds of one of each."""
UNITS = (
    (r"time_?(ms|millis\w*|msec)", "time_s", "multiply it by 0.001"),
    (r"time_?(us|micros\w*|usec)", "time_s", "multiply it by 1e-6"),
    (r"time_?ns", "time_s", "multiply it by 1e-9"),
    (r"t|time|time_?(s|sec|seconds)|timestamp|stamp", "time_s", "if it holds seconds, keep the numbers"),
    (r"position_(\d+)_deg", r"position_\1_rad", "multiply it by 0.0174533"),
    (r"position_(\d+)_mm", r"position_\1_m", "multiply it by 0.001"),
    (r"(?:position|pos|q|angle|theta)_?(\d+)(?:_?rad)?", r"position_\1_rad", "if it holds radians, keep the numbers"),
    (r"torque_(\d+)_(mNm|Nmm)", r"torque_\1_Nm", "multiply it by 0.001"),
    (r"(?:torque|tau|effort|trq)_?(\d+)(?:_?Nm)?", r"torque_\1_Nm", "if it holds N m, keep the numbers"),
    (r"force_(\d+)_mN", r"force_\1_N", "multiply it by 0.001"),
    (r"(?:force)_?(\d+)(?:_?N)?", r"force_\1_N", "if it holds N, keep the numbers"),
    (r"reference_(\d+)_deg", r"reference_\1_rad", "multiply it by 0.0174533"),
    (r"reference_(\d+)_mm", r"reference_\1_m", "multiply it by 0.001"),
    (r"current_(\d+)_mA", r"current_\1_A", "multiply it by 0.001"),
    (r"voltage_(\d+)_mV", r"voltage_\1_V", "multiply it by 0.001"),
    (r"duty_(\d+)_(?:percent|pct)", r"duty_\1", "multiply it by 0.01"),
    (r"supply_mV", "supply_V", "multiply it by 0.001"),
    (r"velocity_(\d+)_deg_s", r"velocity_\1_rad_s", "multiply it by 0.0174533"),
)
"""Patterns of common names, the name in the campaign format, and how to convert; the first match decides.

Names with a unit stand before the same names without: ``t`` and ``timestamp`` are tried after milliseconds.
"""


def advice(column: str, columns: Sequence[str]) -> str:
    """Say what to do about a missing column.

    Parameters
    ----------
    column
        Name in the campaign format, as ``position_0_rad``.
    columns
        Names that the table has.

    Returns
    -------
    str
        A sentence with the column that looks like it and the factor to its unit; empty where none does.
    """
    for name in columns:
        for pattern, known, how in UNITS:
            found = re.fullmatch(pattern, name, re.IGNORECASE)
            if found and name != known and found.expand(known) == column:
                return f"did you mean {name!r} there? {how} and name it {column}"
    near = get_close_matches(column, columns, n=1, cutoff=0.7)
    return f"did you mean {near[0]!r} there?" if near else ""


def looks_like_time(column: str) -> bool:
    """Whether a name is a common one of the time, with or without a unit.

    Parameters
    ----------
    column
        Name of a column.

    Returns
    -------
    bool
    """
    return any(known == "time_s" and re.fullmatch(pattern, column, re.IGNORECASE) for pattern, known, _ in UNITS)


def likely_time_units(interval: float) -> tuple[tuple[str, str], ...]:
    """Find the units in which a time can be, by the interval of its rows.

    Parameters
    ----------
    interval
        Median difference of neighbouring rows, in the unit that is looked for; NaN where it is not known.

    Returns
    -------
    tuple of (str, str)
        Symbol of each unit in which a joint may be logged at that interval, and its seconds as they are written;
        milliseconds and microseconds where there is none.
    """
    shortest, longest = THRESHOLDS.shortest_likely_row_interval_s, THRESHOLDS.longest_row_interval_s
    fitting = tuple(unit for unit in TIME_UNITS if shortest <= interval * float(unit[1]) <= longest)
    return fitting or TIME_UNITS[1:3]
