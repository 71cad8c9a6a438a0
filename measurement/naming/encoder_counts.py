"""Angle of an encoder count: tables with positions in counts in, what loggers' own lines say of a turn out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from haptid.measurement.naming.encoder_lines import LineCounts, counts_in_line, factor_in_line, times
from haptid.measurement.naming.units_in_names import in_counts, understand_column
from haptid.measurement.tables.table import Table
from haptid.support.errors import InputError


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


@dataclass(frozen=True, slots=True, kw_only=True)
class ToldCounts:
    """What a logger says of its encoder.

    Parameters
    ----------
    read
        Counts of a turn, as they were read from the line.
    file
        Name of the table that says so.
    line
        The line above its header.
    """

    read: LineCounts
    file: str
    line: str

    @property
    def number(self) -> int | None:
        """Counts of a turn; None where the line leaves open how many."""
        return self.read.counts[0] if len(self.read.counts) == 1 else None

    @property
    def says(self) -> str:
        """What the file says, for the user."""
        return f"{self.file} says {self.line!r}"

    @property
    def means(self) -> str:
        """How many counts that makes, to stand behind what the file says; empty where it says the number itself."""
        if self.number is None:
            return f", which may be {self.choices}"
        return f", which is {self.read.how}" if self.read.how else ""

    @property
    def choices(self) -> str:
        """The number, or those of which it may be any."""
        return " or ".join(map(str, self.read.counts))


def counts_of_a_turn(tables: Sequence[Table]) -> tuple[ToldCounts, ...]:
    """Read how many counts make a turn from the lines before the tables' headers.

    Parameters
    ----------
    tables
        The user's tables.

    Returns
    -------
    tuple of ToldCounts
        One for each number, of the table that says it first; several where tables differ. A line that leaves the number
        open is among them where no other line says one of its numbers.
    """
    told: dict[tuple[int, ...], ToldCounts] = {}
    for table in tables:
        for one in _told_lines(table):
            told.setdefault(one.read.counts, one)
    numbers = {one.number for one in told.values() if one.number is not None}
    return tuple(one for one in told.values() if one.number is not None or numbers.isdisjoint(one.read.counts))


def _told_lines(table: Table) -> Iterator[ToldCounts]:
    """Yield what the lines of a table say; those that say a number hide those that leave it open."""
    lines = [line.strip("#%; \t") for line in table.preamble]
    factors = [(line, factor) for line in lines if (factor := factor_in_line(line)) is not None]
    told = []
    for line in lines:
        read = counts_in_line(line)
        if read is None:
            continue
        words = line
        # The factor may stand in a line of its own; where several differ, none is taken.
        if len(read.counts) > 1 and len({factor for _, factor in factors}) == 1:
            (said, factor), *_ = factors
            read, words = times(read, factor), f"{line}; {said}"
        told.append(ToldCounts(read=read, file=table.path.name, line=words))
    yield from [one for one in told if one.number is not None] or told


def refuse_open_counts(tables: Sequence[Table], stated: Collection[str]) -> None:
    """Refuse tables that leave the counts of a turn open, or say different ones: one angle would be taken for all.

    Parameters
    ----------
    tables
        The user's tables.
    stated
        Columns of which the user says what they are.

    Raises
    ------
    InputError
        With the angles that a line may mean, or with one for each column where tables that differ are of different
        joints.
    """
    counted = tables_in_counts(tables, stated)
    told = counts_of_a_turn(counted)
    if len(told) > 1:
        raise _different_counts(counted, told, stated)
    if told and told[0].number is None:
        most, *_, least = told[0].read.counts
        todo = f"is it multiplied by {most // least} (quadrature)? --resolution 2*pi/{most}, else 2*pi/{least}"
        raise InputError(told[0].file, expected="the counts of a turn", got=repr(told[0].line), todo=todo)


def _different_counts(counted: Sequence[Table], told: Sequence[ToldCounts], stated: Collection[str]) -> InputError:
    columns: dict[str, set[int | None]] = {}
    for table in counted:
        for column in _columns_in_counts(table, stated):
            columns.setdefault(column, set()).update(one.number for one in _told_lines(table))
    # A campaign states one step for each joint's encoder, whatever the run.
    todo = "a joint has one encoder: make a campaign of each, or state by --resolution what holds for all"
    if all(len(counts) == 1 and None not in counts for counts in columns.values()):
        todo = f"state each: {' '.join(_map_of(column, *counts) for column, counts in columns.items())}"
    where = ", ".join(dict.fromkeys(one.file for one in told))
    got = " and ".join(f"{one.choices} ({one.line!r} in {one.file})" for one in told)
    return InputError(where, expected="one number of counts per turn", got=got, todo=todo)


def _map_of(column: str, counts: int | None) -> str:
    """Word the option that states the angle of a column's counts."""
    target = understand_column(column, 1.0)
    return f"--map '{column}={'' if target is None else target.name}*2*pi/{counts}'"
