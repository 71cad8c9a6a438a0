"""Read one table of a run: CSV (optionally gzipped) or Parquet in, `Table` out.

1. Check the layout of a CSV file (`check_layout`): pandas would read a wrong separator or a repeated name without an
   error.
2. Read all cells as numbers; where one is none, read all again as text, so that an error can show the cell.
3. Drop blank lines at the end, and refuse fewer than 8 rows.

Cells are checked when a column is asked for: columns that nothing uses may hold anything.
"""

from __future__ import annotations

import re
import warnings
import zlib
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from haptid.measurement.tables.damage import CORRECT_CELL, DECIMAL_COMMA, damage_in_one_line, refuse_damaged
from haptid.measurement.tables.layout import check_layout, refuse_bomb, refuse_repeated_names
from haptid.measurement.tables.misnamed import advice
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError, shorten
from haptid.support.files.files import is_file
from haptid.support.installing.extras import need

TEXT_SUFFIXES = (".csv", ".csv.gz")
SUFFIXES = (*TEXT_SUFFIXES, ".parquet")
OTHER_TEXT_SUFFIXES = (".txt", ".tsv", ".dat")
"""Ends of text tables that a campaign is made of, and does not hold itself."""
ISO_DATE = re.compile(
    r"\s*\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}(?::\d{2}(?:\.\d+)?)?\s*(?:Z|[+-]\d{2}:?\d{2})?\s*", re.IGNORECASE
)
"""A date with the time of day, as ISO 8601 has it."""
_DAY_TIME = r"\d{1,2}:\d{2}(?::\d{2}(?:[.,]\d+)?)?"
DOTTED_DATE = re.compile(rf"\s*(\d{{1,2}})\.(\d{{1,2}})\.(\d{{4}})[T ]+({_DAY_TIME})\s*", re.IGNORECASE)
"""A date with the time of day, its parts between dots: the day comes first. Groups: day, month, year, time of day."""
SLASHED_DATE = re.compile(rf"\s*(\d{{4}})/(\d{{1,2}})/(\d{{1,2}})[T ]+({_DAY_TIME})\s*", re.IGNORECASE)
"""The same, its parts between slashes: the year comes first. Groups: year, month, day, time of day."""
UNCERTAIN_DATE = re.compile(
    rf"\s*\d{{1,2}}([./-])\d{{1,2}}\1(?:\d{{4}}|\d{{2}})[T, ]+{_DAY_TIME}\s*(?:[AP]M)?\s*", re.IGNORECASE
)
"""A date with the time of day whose first part may be the day, the month or the year, unless it is a `DOTTED_DATE`."""
TIME_OF_DAY = re.compile(r"\s*(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)\s*")
"""A time of day without its date, or hours of a stopwatch. Groups: hours, minutes, seconds."""
READ_BY_INIT = "dates are read where a campaign is made (haptid init): write seconds here"
READ_AS_TIME = "of dates, those of one column, the time, are read: leave one such column, or write a number here"
"""What a program does about a date in a data frame that was not read."""
WRITE_ISO = "the order of the date is not certain: write ISO 8601, as 2026-03-12T10:00:00.004"
TODO_BY_CELL = (
    (re.compile(r"\s*[+-]?\d{1,3}(,\d{3})+\.\d*\s*|\s*[+-]?\d{1,3}(,\d{3}){2,}\s*"),
     "export without commas between thousands"),
    (re.compile(r"\s*[+-]?\d{1,3}(\.\d{3})+,\d*\s*|\s*[+-]?\d{1,3}(\.\d{3}){2,}\s*"),
     "export without points between thousands"),
    (re.compile(r"\s*\u2212\d.*"), "write the minus as -: U+2212 stands there"),
    (re.compile(r"\s*[+-]?\d*,\d+(e[+-]?\d+)?\s*", re.IGNORECASE), DECIMAL_COMMA),
    (ISO_DATE, READ_BY_INIT),
    (DOTTED_DATE, READ_BY_INIT),
    (SLASHED_DATE, READ_BY_INIT),
    (UNCERTAIN_DATE, WRITE_ISO),
    (TIME_OF_DAY, READ_BY_INIT),
)  # fmt: skip
"""Forms of a cell that is no number, and what to do about them; the first match decides."""
DROP_EMPTY = "leave such rows out, as by df.dropna()"
"""What a program does about an empty cell of a data frame; `haptid init` leaves the row out itself."""
EMPTY_COLUMN = "no row has a number there: leave the run out"
SHOWN_CELL_CHARACTERS = 40
"""Characters of a cell that an error shows."""
EXACT: dict[str, Any] = {} if int(pd.__version__.split(".")[0]) >= 3 else {"float_precision": "round_trip"}
"""Python's float() to the last bit, as pandas does by itself from version 3 on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Give the columns of a file by name, as numbers, with their places for error messages.

    Parameters
    ----------
    path
        File of the table, or a name for errors where it comes from no file.
    frame
        Its cells, as numbers or as text.
    lines_before
        Number of lines before the header.
    in_memory
        Whether the table comes from no file.
    file
        Name of the table in a campaign, where it is not that of the file: of a recording, or a part of one.
    preamble
        Lines before the header, where they were kept.
    joints
        Names of joints 0, 1 … of its columns, where it is of a recording that has them.
    entries
        Name of the list in the file whose entries the rows are, which are counted from 0; empty where there is none.
    rows
        Index of each row in the file, where others were left out; None where all rows are there.
    """

    path: Path
    frame: pd.DataFrame
    lines_before: int = 0
    in_memory: bool = False
    file: str = ""
    preamble: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    entries: str = ""
    rows: NDArray[np.int_] | None = None

    @property
    def file_name(self) -> str:
        """Name of the run's table in a campaign."""
        return self.file or self.path.name

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.frame.columns)

    @property
    def header(self) -> str:
        """Name the header for an error message."""
        return f"{self.path}, line {self.lines_before + 1}" if self.is_text else f"{self.path}, columns"

    @property
    def is_text(self) -> bool:
        """Whether the table is a text file, whose lines an error can name."""
        return not self.in_memory and self.path.name.endswith((*TEXT_SUFFIXES, *OTHER_TEXT_SUFFIXES))

    def row(self, index: int) -> str:
        """Name a row for an error message: the line of the text file, the entry, or the row of any other table, from 1.

        Parameters
        ----------
        index
            Index of the row, from 0.

        Returns
        -------
        str
            File and number; in a text file, the header and the lines before it count, and rows that were left out do
            everywhere.
        """
        index = self._index_in_file(index)
        if self.entries:
            return f"{self.path}, {self.entries}[{index}]"
        return f"{self.path}, line {self.lines_before + index + 2}" if self.is_text else f"{self.path}, row {index + 1}"

    def _index_in_file(self, index: int) -> int:
        """Return the index of a row among all rows of the file."""
        return index if self.rows is None else int(self.rows[index])

    def keep(self, rows: NDArray[np.int_]) -> Table:
        """Return the table with some of its rows, which keep their places for error messages.

        Parameters
        ----------
        rows
            Their indices, ascending.

        Returns
        -------
        Table
        """
        places = rows if self.rows is None else self.rows[rows]
        return replace(self, frame=self.frame.iloc[rows].reset_index(drop=True), rows=places)

    def numbers(self, column: str) -> Array:
        """Return a column as finite numbers.

        Parameters
        ----------
        column
            Name in the campaign format, as ``torque_0_Nm``.

        Returns
        -------
        ndarray, shape (n_t,)
            In the unit that the name states.

        Raises
        ------
        InputError
            Where the column is missing, or a cell holds no finite number; it names the cell's line.
        """
        if column not in self.frame:
            todo = advice(column, self.columns) or f"it has {_some(self.columns)}"
            raise InputError(self.header, expected=f"a column {column}", got="none", todo=todo)
        values = self.loosely(column)
        bad = np.flatnonzero(~(np.abs(values) < THRESHOLDS.largest_reading))  # negated, so that NaN is bad, too
        if bad.size:
            raise self._no_number(column, int(bad[0]), values)
        return values

    def _no_number(self, column: str, index: int, values: Array) -> InputError:
        """Return the error of a cell that is no finite number or is too large; it shows the cell as it is written."""
        cell = self._as_written(column, index)
        got = "an empty or NaN cell" if pd.isna(cell) else repr(shorten(str(cell), SHOWN_CELL_CHARACTERS))
        if index == 0 and np.isnan(values).all() and not pd.isna(cell):
            got += " and no number in any other row"
        no_number = np.isnan(values[index]) or "inf" in str(cell).lower()
        todo = CORRECT_CELL if no_number else f"no value is above {THRESHOLDS.largest_reading:g}"
        if self.in_memory and pd.isna(cell):
            todo = EMPTY_COLUMN if np.isnan(values).all() else DROP_EMPTY
        todo = next((known for form, known in TODO_BY_CELL if form.fullmatch(str(cell))), todo)
        if self.in_memory and todo == READ_BY_INIT:
            todo = READ_AS_TIME if np.isnan(values).all() else CORRECT_CELL
        return InputError(f"{self.row(index)}, {column}", expected="a finite number", got=got, todo=todo)

    def _as_written(self, column: str, index: int) -> Any:
        cell = self.frame[column].iloc[index]
        if not self.is_text or isinstance(cell, str) or pd.isna(cell):
            return cell
        # Numbers were read as binary: the file is read again, only for this error.
        texts = _read_frame(self.path, as_text=True)
        return texts.iloc[self._index_in_file(index), list(self.frame.columns).index(column)]

    def loosely(self, column: str) -> Array:
        """Return a column as numbers, NaN where a cell holds none, shape (n_t,).

        Parameters
        ----------
        column
            Name of a column of the table.

        Returns
        -------
        ndarray, shape (n_t,)
            Numbers in the unit of the column; NaN throughout for a column of true and false.
        """
        if self.frame[column].dtype == np.float64:
            return self.frame[column].to_numpy()
        if pd.api.types.is_bool_dtype(self.frame[column].dtype):  # true and false are no numbers
            return np.full(len(self.frame), np.nan)
        cells = self.frame[column].to_numpy(dtype=object, na_value=np.nan)
        try:
            return cells.astype(np.float64)
        except (TypeError, ValueError):
            return np.array([_number(cell) for cell in cells], dtype=np.float64)

    def interval(self, column: str) -> float:
        """Return the median distance of neighbouring rows, in the unit of the column.

        Parameters
        ----------
        column
            Name of a column of the table.

        Returns
        -------
        float
            NaN where fewer than two cells hold a number.
        """
        values = self.loosely(column)
        intervals = np.abs(np.diff(values[np.isfinite(values)]))
        return float(np.median(intervals)) if intervals.size else float("nan")

    def time(self) -> Array:
        """Read the column ``time_s``.

        Returns
        -------
        ndarray, shape (n_t,)
            Times [s], increasing from row to row.

        Raises
        ------
        InputError
            Where it is missing, a cell is no finite number, or it does not increase from row to row.
        """
        t = self.numbers("time_s")
        back = np.flatnonzero(np.diff(t) <= 0)
        if back.size:
            k = int(back[0]) + 1
            got = f"{t[k]} s after {t[k - 1]} s"
            where = f"{self.row(k)}, time_s"
            todo = _remedy_of_times(t, k, in_memory=self.in_memory)
            raise InputError(where, expected="time that increases from row to row", got=got, todo=todo)
        return t


def _remedy_of_times(t: Array, k: int, *, in_memory: bool) -> str:
    """Say what to do about times of which that of row k does not follow the one before."""
    intervals = np.diff(t)
    repeated = int(np.count_nonzero(intervals == 0.0))
    if t[k] == t[k - 1] and repeated > THRESHOLDS.largest_share_of_rows_left_out * t.size:
        # Without them hardly half of the rows would be left, at wrong times.
        more = "give it more digits, as float64" if in_memory else "export it with more digits"
        return f"{repeated} of {t.size} rows repeat a time: {more}"
    if t[k] == t[k - 1]:
        return 'leave such rows out, as by df.drop_duplicates("time_s")' if in_memory else "take such rows out"
    if t[k] == 0.0 and not t[k:].any():
        return "the rows from there on are empty: leave them out"
    # Sorted rows of two runs would be mixed.
    if in_memory:
        return 'sort the rows, as by df.sort_values("time_s"), or give each run a frame of its own'
    return "sort the rows by their time, or give each run a file of its own"


def read_table(path: Path, *, as_text: bool = False) -> Table:
    """Read the table of a run.

    Parameters
    ----------
    path
        File that ends in ``.csv``, ``.csv.gz`` or ``.parquet``.
    as_text
        Whether each cell of a CSV file stays as it is written, for a copy that keeps all digits.

    Returns
    -------
    Table
        With blanks around the column names and blank lines at the end removed.

    Raises
    ------
    InputError
        For a missing file, an unknown kind of file, a damaged one, one in which a column's name occurs twice, and one
        with fewer than 8 rows.
    """
    if not is_file(path):
        names = _neighbours(path)
        near = get_close_matches(path.name, [name for name in names if name != path.name], n=1)
        todo = f"did you mean {near[0]}?" if near else ""
        got = "a folder" if path.name in names else "no such file"
        raise InputError(str(path), expected="a table of a run", got=got, todo=todo)
    if not path.name.endswith(SUFFIXES):
        raise InputError(str(path), expected=f"a file that ends in {', '.join(SUFFIXES)}", got=repr(path.name))
    if path.suffix != ".parquet":
        check_layout(path)
    frame = _read_frame(path, as_text=as_text)
    frame.columns = pd.Index([str(name).strip() for name in frame.columns])
    refuse_repeated_names(f"{path}, columns", list(frame.columns))
    filled = np.flatnonzero(frame.notna().any(axis=1).to_numpy())
    frame = frame.iloc[: filled[-1] + 1 if filled.size else 0]  # blank lines at the end of a file are no rows
    if len(frame) < THRESHOLDS.least_rows_of_table:
        raise InputError(str(path), expected=f"at least {THRESHOLDS.least_rows_of_table} rows", got=f"{len(frame)}")
    return Table(path=path, frame=frame)


def _read_frame(path: Path, *, as_text: bool) -> pd.DataFrame:
    if path.suffix == ".parquet":
        return read_parquet(path)
    broken: tuple[Any, ...] = (ValueError, OSError, EOFError, zlib.error, pd.errors.ParserWarning)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            common: dict[str, Any] = {"encoding": "utf-8-sig", "skip_blank_lines": False, "skipinitialspace": True}
            if not as_text:
                with suppress(ValueError):  # a cell that is no number: read again as text, so that it can be shown
                    frame = pd.read_csv(path, index_col=False, dtype=np.float64, **common, **EXACT)
                    if not _holds_flags(path, frame, common):
                        return frame
            return pd.read_csv(path, index_col=False, dtype=str, **common)
    except pd.errors.EmptyDataError:
        raise InputError(
            str(path), expected=f"a header and at least {THRESHOLDS.least_rows_of_table} rows", got="an empty file"
        ) from None
    except broken as error:
        raise refuse_damaged(path, type(error).__name__) from None


def _holds_flags(path: Path, frame: pd.DataFrame, common: dict[str, Any]) -> bool:
    """Whether a column holds true and false throughout, which pandas takes for 1 and 0."""
    binary = [k for k in range(frame.shape[1]) if len(frame) and np.isin(frame.iloc[:, k].to_numpy(), (0.0, 1.0)).all()]
    if not binary:
        return False
    # Only columns of zeros and ones can be flags, and their first row shows it: the whole file need not be read again.
    texts = pd.read_csv(path, index_col=False, dtype=str, usecols=binary, nrows=1, **common)
    return any(str(cell).strip().lower() in ("true", "false") for cell in texts.iloc[0])


def read_parquet(path: Path) -> pd.DataFrame:
    """Read all columns of a Parquet file.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    DataFrame
        Columns as the file has them.

    Raises
    ------
    InputError
        Where the extra is not installed, the file is damaged, or it unpacks to an absurd size.
    """
    need("parquet", str(path))
    import pyarrow.parquet as pq  # noqa: PLC0415 (an extra)

    with damage_in_one_line(path, "a table in Parquet", "export it again"):
        about = pq.read_metadata(path)
        refuse_bomb(path, about.num_rows * about.num_columns * 8)
        return pq.read_table(path).to_pandas(ignore_metadata=True)


def _number(cell: object) -> float:
    try:
        return float(cell)  # type: ignore[arg-type] # whatever float() refuses is no number
    except (TypeError, ValueError):
        return float("nan")


def _neighbours(path: Path) -> list[str]:
    try:
        return [item.name for item in path.parent.iterdir()]
    except (OSError, ValueError):  # no such folder, or a name that no folder can have
        return []


def _some(names: tuple[str, ...], most: int = 12) -> str:
    return ", ".join(names[:most]) + (", …" if len(names) > most else "")
