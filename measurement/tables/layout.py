"""Check the layout of a CSV file before pandas reads it: path in, nothing out, or an `InputError` with the remedy.

Spreadsheets and loggers write comments, other separators and decimal commas, which pandas would read as wrong numbers
or refuse without naming the line.
"""

from __future__ import annotations

import csv
import gzip
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from haptid.measurement.tables.damage import refuse_damaged, too_many_cells
from haptid.measurement.thresholds import THRESHOLDS
from haptid.support.errors import InputError

SEPARATORS = ((";", "semicolons"), ("\t", "tabs"), ("|", "bars"), (" ", "blanks"))
ALWAYS = ";\t"
"""Signs that separate columns where they occur; the others do where the header holds no comma."""


def check_layout(path: Path) -> None:
    """Refuse comments before the header, a missing header, repeated names, other separators and ragged rows.

    Parameters
    ----------
    path
        CSV file, or a gzipped one (``.gz``); its first 200 lines are checked.

    Raises
    ------
    InputError
        With the line at fault and what to do; also where a gzipped file unpacks to an absurd size.
    """
    try:
        if path.suffix == ".gz":
            refuse_packed_bomb(path)
        with _open(path) as stream:
            longest, most = THRESHOLDS.longest_line_characters, THRESHOLDS.most_lines_of_layout
            lines = [stream.readline(longest) for _ in range(most)]
    except UnicodeDecodeError as error:  # anywhere in the block that was read ahead
        raise refuse_damaged(path, type(error).__name__) from None
    except (OSError, EOFError, zlib.error):
        return  # said by whoever reads the file whole
    _check_header(path, lines[0].strip(), empty=not any(line.strip() for line in lines))
    _check_rows(path, lines)


def refuse_repeated_names(where: str, names: Sequence[str]) -> None:
    """Refuse a header in which a name occurs twice.

    pandas would number the second one, as in ``angle (rad).1``, and that number would be read as a joint's.

    Parameters
    ----------
    where
        Place of the header, for the message.
    names
        Names of the columns; blanks around them and empty ones count for nothing.

    Raises
    ------
    InputError
        With the first name that occurs again.
    """
    stripped = [name.strip() for name in names]
    for name in stripped:
        if name and stripped.count(name) > 1:
            expected, got = "each column once", f"{stripped.count(name)} columns named {name!r}"
            raise InputError(where, expected=expected, got=got, todo="rename one of them, or take it out")


def refuse_bomb(path: Path, unpacked: int) -> None:
    """Refuse a table that unpacks to absurdly more than its file.

    Parameters
    ----------
    path
        File of the table.
    unpacked
        Size of the unpacked table [bytes].

    Raises
    ------
    InputError
        Where it is larger than 64 MiB and than 250 times the file.
    """
    packed = path.stat().st_size
    if unpacked > max(THRESHOLDS.largest_unpacked_bytes, THRESHOLDS.largest_unpacked_over_packed * packed):
        expected = f"a table that unpacks to at most {THRESHOLDS.largest_unpacked_over_packed} times its {packed} bytes"
        raise InputError(str(path), expected=expected, got=f"{unpacked >> 20} MiB", todo="export it again")


def refuse_packed_bomb(path: Path) -> None:
    """Refuse a gzipped table that unpacks to absurdly more than its file, without unpacking all of it.

    Parameters
    ----------
    path
        Gzipped file.

    Raises
    ------
    InputError
        As `refuse_bomb`.
    OSError, EOFError, zlib.error
        Where the file is damaged.
    """
    if path.stat().st_size * 1032 < THRESHOLDS.largest_unpacked_bytes:  # gzip never packs below a 1032nd
        return
    unpacked = 0
    with gzip.open(path) as stream:
        while chunk := stream.read(1 << 20):
            unpacked += len(chunk)
            refuse_bomb(path, unpacked)


def _open(path: Path) -> TextIO:
    if path.suffix == ".gz":
        return gzip.open(path, "rt", encoding="utf-8-sig", newline=None)
    return path.open(encoding="utf-8-sig")


def _check_header(path: Path, header: str, *, empty: bool) -> None:
    where = f"{path}, line 1"
    if not header and not empty:
        todo = "take the blank lines before the header away"
        raise InputError(where, expected="the header", got="a blank line", todo=todo)
    if header.startswith(("#", "%", "//")):
        todo = "take the lines before the header away"
        raise InputError(where, expected="the header", got=f"a comment: {header[:40]!r}", todo=todo)
    for sign, name in SEPARATORS:
        if sign in header and (sign in ALWAYS or "," not in header):
            todo = "export it with commas and decimal points"
            raise InputError(where, expected="columns separated by commas", got=name, todo=todo)
    cells = [cell.strip() for cell in header.split(",")]
    if header and all(_is_number(cell) for cell in cells if cell):
        todo = "write a first line with the names of the columns, as in time_s,torque_0_Nm,position_0_rad"
        raise InputError(where, expected="the names of the columns", got=repr(header[:40]), todo=todo)
    with suppress(csv.Error):  # said by whoever reads the file whole
        refuse_repeated_names(where, next(csv.reader([header]), []))


def _check_rows(path: Path, lines: list[str]) -> None:
    if any('"' in line for line in lines):
        return  # a quoted cell may hold commas
    columns = lines[0].count(",") + 1
    # A row with fewer cells than the header has empty ones at its end; one with more has, mostly, decimal commas.
    for number, line in enumerate(lines[1:], start=2):
        cells = line.count(",") + 1
        if line.strip() and cells > columns:
            spare = line.rstrip().endswith(",") and cells == columns + 1
            if not spare:
                where = f"{path}, line {number}"
                raise too_many_cells(where, columns, cells)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
