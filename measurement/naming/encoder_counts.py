"""Angle of an encoder count: tables with positions in counts in, what a logger's own lines say of a turn out."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from haptid.measurement.naming.units_in_names import in_counts, understand_column
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError

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


def tables_in_counts(tables: Sequence[Table], stated: Collection[str]) -> list[Table]:
    """Find the tables with a position in encoder counts that has no stated factor.

    Parameters
    ----------
    tables
        The user's tables.
    stated
        Columns of which the user says what they are.

    Returns
    -------
    list of Table
    """
    return [table for table in tables if _columns_in_counts(table, stated)]


def _columns_in_counts(table: Table, stated: Collection[str]) -> list[str]:
    return [name for name in table.columns if name not in stated and in_counts(name)]


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

    @property
    def words(self) -> str:
        """What the file says, for the user."""
        return f"{self.file} says {self.line!r}"


def counts_of_a_turn(tables: Sequence[Table]) -> tuple[ToldCounts, ...]:
    """Read how many counts make a turn from the lines before the tables' headers.

    Parameters
    ----------
    tables
        The user's tables.

    Returns
    -------
    tuple of ToldCounts
        One for each number, of the table that says it first; several where the tables differ.
    """
    told: dict[int, ToldCounts] = {}
    for one in _told_lines(tables):
        told.setdefault(one.counts, one)
    return tuple(told.values())


def _told_lines(tables: Sequence[Table]) -> Iterator[ToldCounts]:
    for table in tables:
        for line in table.preamble:
            found = next(filter(None, (form.search(line) for form in COUNTS_OF_A_TURN)), None)
            if found is not None and int(found["number"]) > 1:
                yield ToldCounts(int(found["number"]), table.path.name, line.strip("#%; \t"))


def refuse_different_counts(tables: Sequence[Table], stated: Collection[str]) -> None:
    """Refuse tables that say different counts of a turn: one angle would be taken for the counts of all of them.

    Parameters
    ----------
    tables
        The user's tables.
    stated
        Columns of which the user says what they are.

    Raises
    ------
    InputError
        With an angle for each column where the tables that differ are of different joints.
    """
    counted = tables_in_counts(tables, stated)
    told = counts_of_a_turn(counted)
    if len(told) < 2:
        return
    columns: dict[str, set[int]] = {}
    for table in counted:
        for column in _columns_in_counts(table, stated):
            columns.setdefault(column, set()).update(one.counts for one in _told_lines([table]))
    # A campaign states one step for each joint's encoder, whatever the run.
    todo = "a joint has one encoder: make a campaign of each, or state by --resolution what holds for all"
    if all(len(counts) == 1 for counts in columns.values()):
        todo = f"state each: {' '.join(_map_of(column, *counts) for column, counts in columns.items())}"
    where = ", ".join(dict.fromkeys(one.file for one in told))
    got = " and ".join(f"{one.counts} ({one.line!r} in {one.file})" for one in told)
    raise InputError(where, expected="one number of counts per turn", got=got, todo=todo)


def _map_of(column: str, counts: int) -> str:
    """Word the option that states the angle of a column's counts."""
    target = understand_column(column, 1.0)
    return f"--map '{column}={'' if target is None else target.name}*2*pi/{counts}'"
