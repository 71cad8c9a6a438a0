"""Angle of an encoder count: tables with positions in counts in, what a logger's own lines say of a turn out."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from haptid.measurement.naming.units_in_names import in_counts
from haptid.measurement.tables.table import Table

_COUNTS = r"(?:counts?|cnts?|ticks?)"
_TURN = r"(?:turn|rev(?:olution)?|rotation)"
COUNTS_OF_A_TURN = tuple(
    re.compile(form, re.IGNORECASE)
    for form in (
        rf"(?<![a-z]){_COUNTS}[\s_-]*(?:per|/|a)[\s_-]*{_TURN}\w*\W{{0,4}}(?P<number>\d+)(?:[.,]0+)?(?![\d.,])",
        rf"(?<![\d.,])(?P<number>\d+)[\s_-]*{_COUNTS}[\s_-]*(?:per|/|a)[\s_-]*{_TURN}",
    )
)
"""Lines that say how many counts make a turn, as ``counts per turn: 4096`` and ``4096 counts/rev``.

Lines, pulses and cycles per turn are left alone: one of them makes four counts, or two, or one.
"""


def holds_counts(tables: Sequence[Table], stated: Collection[str]) -> bool:
    """Whether a position without a stated factor is in encoder counts.

    Parameters
    ----------
    tables
        The user's tables.
    stated
        Columns of which the user says what they are.

    Returns
    -------
    bool
    """
    return any(in_counts(name) for table in tables for name in table.columns if name not in stated)


@dataclass(frozen=True, slots=True)
class ToldCounts:
    """What a logger says of its encoder.

    Parameters
    ----------
    counts
        Counts of a turn.
    file
        Name of the table that says so.
    line
        The line above its header.
    """

    counts: int
    file: str
    line: str


def counts_of_a_turn(tables: Sequence[Table]) -> ToldCounts | None:
    """Read how many counts make a turn from the lines before the tables' headers.

    Parameters
    ----------
    tables
        The user's tables.

    Returns
    -------
    ToldCounts or None
        Of the table that says so first; None where none does, or two say different numbers.
    """
    told: dict[int, ToldCounts] = {}
    for table in tables:
        for line in table.preamble:
            found = next(filter(None, (form.search(line) for form in COUNTS_OF_A_TURN)), None)
            if found is not None:
                counts = int(found["number"])
                told.setdefault(counts, ToldCounts(counts, table.path.name, line.strip("#%; \t")))
    return next(iter(told.values())) if len(told) == 1 and min(told) > 1 else None
