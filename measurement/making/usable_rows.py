"""Rows that a run can be made of: a logger's `Table` in, `Table` without empty or repeated rows out, cut at its gaps.

1. Leave out rows in which a needed cell is empty, and rows that repeat the time of the row before; the torque that such
   a row has goes into the row before it (`with_held_commands`).
2. Leave out rows that an earlier table has as well (`without_shared_rows`): loggers that begin a new file overlap.
3. Count a position on where its counter wraps: a jump by a whole period between two rows is no motion (`counted_on`).
4. Cut where rows are missing for longer than a few rows, left out above or lost by the recorder: no torque is known
   there (`cut_at_gaps`).

A table in which anything else is at fault stays as it is, so that the error of the later reading names its line.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from haptid.measurement.format.columns import KNOWN
from haptid.measurement.making.held_commands import with_held_commands
from haptid.measurement.signals.gaps import find_gaps
from haptid.measurement.tables.table import SUFFIXES, Table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError

Mask = NDArray[np.bool_]

TURN = 2.0 * np.pi
"""Period of an absolute encoder [rad]."""
MOST_BITS_OF_COUNTER = 32
"""Bits of the widest counter that is looked for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UsableTable:
    """A table with the rows that can be used.

    Parameters
    ----------
    table
        Its rows, all cells that are needed filled.
    lost
        Whether rows were left out before each row, shape (n_t,).
    about
        What was done to it, in words for the user; empty where nothing.
    """

    table: Table
    lost: Mask
    about: tuple[str, ...] = ()


def usable_rows(table: Table, needed: Sequence[str], time: str, held: Sequence[str] = ()) -> UsableTable:
    """Leave out rows with empty cells and rows that repeat a time.

    Parameters
    ----------
    table
        The user's table.
    needed
        Columns that a run needs.
    time
        Column of the time.
    held
        Columns with commands that hold until the next row: those of rows with an empty cell go into the row before.

    Returns
    -------
    UsableTable
        The table itself where another cell than an empty one holds no number, the time runs back, or more rows than
        `THRESHOLDS.largest_share_of_rows_left_out` would go.

    Raises
    ------
    InputError
        Where more rows than that have an empty cell: no run is left of signals of two rates.
    """
    whole = UsableTable(table=table, lost=np.zeros(len(table.frame), dtype=bool))
    needed = [name for name in needed if name in table.columns and not table.frame[name].isna().all()]
    if time not in needed:
        return whole
    values = {name: table.loosely(name) for name in needed}
    empty = np.any([table.frame[name].isna().to_numpy() for name in needed], axis=0)
    bad = np.any([~(np.abs(v) < THRESHOLDS.largest_reading) for v in values.values()], axis=0)
    if np.any(bad & ~empty) or empty.all():
        return whole
    filled = np.flatnonzero(~empty)
    repeats = np.diff(values[time][filled], prepend=-np.inf) == 0.0
    kept = filled[~repeats]
    left_out = len(empty) - kept.size
    if empty.sum() > THRESHOLDS.largest_share_of_rows_left_out * len(empty):
        raise _mostly_empty(table, needed, empty)
    if left_out == 0 or left_out > THRESHOLDS.largest_share_of_rows_left_out * len(empty):
        return whole
    if np.any(np.diff(values[time][kept]) < 0.0):
        return whole
    lost = np.diff(np.cumsum(empty)[kept], prepend=0) > 0
    # Rows before the first complete one are not missing: the run begins there.
    lost[0] = False
    repeated = int(repeats.sum())
    words = [
        _count_rows(int(empty.sum()), "with empty cells"),
        _count_rows(repeated, f"that repeat{'s' * (repeated == 1)} a time"),
    ]
    about = " and ".join(word for word in words if word)
    less = with_held_commands(table, kept, [name for name in held if name in needed], time)
    return UsableTable(table=less, lost=lost, about=(f"without {about}",))


def _mostly_empty(table: Table, needed: Sequence[str], empty: Mask) -> InputError:
    """Return the error of a table too many of whose rows have an empty cell; it names the first of them."""
    row = int(np.flatnonzero(empty)[0])
    column = next(name for name in needed if pd.isna(table.frame[name].iloc[row]))
    most = f"{100 * THRESHOLDS.largest_share_of_rows_left_out:.0f} %"
    todo = (
        f"{int(empty.sum())} of {len(empty)} rows have one, and at most {most} are left out: fill them, or bring "
        "signals of different rates to one rate"
    )
    return InputError(f"{table.row(row)}, {column}", expected="a finite number", got="an empty or NaN cell", todo=todo)


def _count_rows(rows: int, what: str) -> str:
    return f"{rows} row{'s' * (rows > 1)} {what}" if rows else ""


def counted_on(usable: UsableTable, columns: Sequence[str], step: float | None) -> UsableTable:
    """Count positions on where their counter wraps.

    Parameters
    ----------
    usable
        Table whose columns have the names and units of the campaign format.
    columns
        Positions [rad] or [m].
    step
        Size of one count [rad] or [m]; None where it is not known.

    Returns
    -------
    UsableTable
    """
    frame, about = usable.table.frame, list(usable.about)
    for name in columns:
        y = usable.table.loosely(name)
        period = wrap_period(y, turns=name.endswith("_rad"), step=step)
        if period:
            frame = frame.assign(**{name: np.unwrap(y, period=period)})
            about.append(f"{name} counted on where it wraps by {period:.4g} {'rad' if name.endswith('_rad') else 'm'}")
    return replace(usable, table=replace(usable.table, frame=frame), about=tuple(about))


def wrap_period(y: Array, *, turns: bool, step: float | None) -> float:
    """Find the period by which a counter wraps.

    Parameters
    ----------
    y
        Readings [rad] or [m], shape (n_t,).
    turns
        Whether they are angles, which may wrap by a turn.
    step
        Size of one count; None where it is not known.

    Returns
    -------
    float
        A turn, or a power of two of the step; 0 where the reading does not jump by one of them. After the jump the
        motion goes on as before it, at no more than `THRESHOLDS.largest_step_at_wrap` times its fastest row. A
        reference that rests but for steps of a turn does not move, and does not wrap.
    """
    candidates = [TURN] if turns else []
    if step:
        candidates += [step * 2.0**bits for bits in range(THRESHOLDS.least_encoder_bits, MOST_BITS_OF_COUNTER + 1)]
    d = np.diff(y)
    if not np.all(np.isfinite(d)):
        return 0.0
    for period in sorted(candidates):
        jumps = np.abs(d) > period / 2.0
        if not jumps.any() or jumps.all():
            continue
        usual = float(np.abs(d[~jumps]).max())
        after = np.abs(d[jumps] - period * np.round(d[jumps] / period))
        limit = max(THRESHOLDS.largest_step_at_wrap * usual, step or 0.0)
        if usual > 0.0 and np.all(np.abs(np.round(d[jumps] / period)) == 1.0) and after.max() <= limit < period / 2.0:
            return period
    return 0.0


def without_shared_rows(tables: Sequence[UsableTable]) -> list[UsableTable]:
    """Leave out the rows that an earlier table has as well.

    Parameters
    ----------
    tables
        Tables of one campaign, their columns named as in the campaign format.

    Returns
    -------
    list of UsableTable
        Where all rows that two tables have in common in time are equal, the later one has the others alone; a table
        that is wholly in another one stays, since it may be a copy that was used otherwise.
    """
    result: list[UsableTable] = []
    for usable in tables:
        for earlier in result:
            usable = _less(usable, earlier)  # noqa: PLW2901 (each earlier table may share other rows)
        result.append(usable)
    return result


def _less(later: UsableTable, earlier: UsableTable) -> UsableTable:
    names = [name for name in later.table.columns if KNOWN.fullmatch(name) and name in earlier.table.columns]
    if "time_s" not in names or len(names) == 1:
        return later
    t, known = later.table.loosely("time_s"), earlier.table.loosely("time_s")
    _, here, there = np.intersect1d(t, known, return_indices=True)
    if not THRESHOLDS.least_rows_of_table <= here.size < t.size:
        return later
    within = (t >= known[0]) & (t <= known[-1])
    same = [
        np.array_equal(later.table.loosely(n)[here], earlier.table.loosely(n)[there], equal_nan=True) for n in names
    ]
    if within.sum() != here.size or not all(same):
        return later
    kept = np.setdiff1d(np.arange(t.size), here)
    if kept.size < THRESHOLDS.least_rows_of_table:
        return later
    # What lies on either side of the shared rows is no one run.
    lost = later.lost[kept] | (np.diff(kept, prepend=kept[0] - 1) > 1)
    said = f"without {here.size} rows that {earlier.table.file_name} has as well"
    return UsableTable(table=later.table.keep(kept), lost=lost, about=(*later.about, said))


def cut_at_gaps(usable: UsableTable, taken: Collection[str] = ()) -> list[UsableTable]:
    """Cut a table where rows are missing for longer than a few rows.

    Parameters
    ----------
    usable
        Table whose columns have the names of the campaign format.
    taken
        Names of all tables, which no part may get.

    Returns
    -------
    list of UsableTable
        Parts named ``<file>_1``, ``<file>_2`` …; parts that are too short to show anything are left out. The
        table itself where no rows are missing or no part is long enough.
    """
    t = usable.table.loosely("time_s")
    gaps = np.diff(t, prepend=t[0])
    usual = float(np.median(gaps[1:]))
    left_out = usable.lost & (gaps > THRESHOLDS.longest_gap_in_run_rows * usual)
    cuts = np.flatnonzero(left_out | find_gaps(t))
    least = max(THRESHOLDS.least_rows_of_part, THRESHOLDS.least_share_of_part * t.size)
    parts = [rows for rows in np.split(np.arange(t.size), cuts) if rows.size >= least]
    if cuts.size == 0 or not parts:
        return [usable]
    dropped = t.size - sum(rows.size for rows in parts)
    cut = f"cut where rows are missing, into {len(parts)} run{'s' * (len(parts) > 1)}"
    said = (*usable.about, cut, *([f"{dropped} rows of shorter parts dropped"] if dropped else []))
    names = (_part_name(usable.table.file_name, number) for number in itertools.count(1))
    free_names = (name for name in names if name not in taken)
    result = []
    for number, (rows, name) in enumerate(zip(parts, free_names, strict=False), start=1):
        table = replace(usable.table.keep(rows), file=name)
        result.append(UsableTable(table=table, lost=np.zeros(rows.size, dtype=bool), about=said if number == 1 else ()))
    return result


def _part_name(name: str, number: int) -> str:
    suffix = next((end for end in sorted(SUFFIXES, key=len, reverse=True) if name.endswith(end)), "")
    return f"{name[: len(name) - len(suffix)]}_{number}{suffix}"
