"""Tell of damaged files in one line: path in, `InputError` out.

Of a CSV file that pandas could not read, the line at fault is located.
"""

from __future__ import annotations

import csv
import gzip
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from haptid.support.errors import InputError
from haptid.support.installing.extras import cannot_be_imported

CORRECT_CELL = "correct the cell, or take its row out"
"""What to do about a cell that holds no number."""
DECIMAL_COMMA = "where a comma is the decimal sign, export with decimal points"


@contextmanager
def damage_in_one_line(path: Path, expected: str, todo: str) -> Iterator[None]:
    """Turn whatever a library raises on a damaged file within the block into one line.

    Parameters
    ----------
    path
        The file.
    expected
        Kind of the file.
    todo
        Remedy.

    Raises
    ------
    InputError
        That of the block as it is, or one that names the library's error; an import that fails is no damage.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # the libraries and their decoders raise anything on a damaged file
        if isinstance(error, ImportError) and error.name:  # a library may load parts of itself where it needs them
            raise cannot_be_imported(error.name, str(path), error) from None
        got = f"a damaged file ({type(error).__name__})"
        raise InputError(str(path), expected=expected, got=got, todo=todo) from None


def refuse_damaged(path: Path, kind: str) -> InputError:
    """Return the error of a text that could not be read as a table, with the first line at fault.

    Parameters
    ----------
    path
        CSV file, or a gzipped one (``.gz``).
    kind
        Name of the reader's error, for a file in which no line looks wrong.

    Returns
    -------
    InputError
        For the caller to raise: a byte that is no UTF-8, an odd number of quotes, or more cells than the header has.
    """
    columns = 0
    try:
        with _open(path) as stream:
            for number, raw in enumerate(stream, start=1):
                fault = _fault(raw, f"{path}, line {number}", columns)
                if fault is not None:
                    return fault
                columns = columns or _cells(raw.decode("utf-8-sig"))
    except (OSError, EOFError, zlib.error):
        kind = "a damaged archive" if path.suffix == ".gz" else kind
    got = f"a damaged file ({kind})"
    return InputError(str(path), expected="a table in CSV with a header line", got=got, todo="export it again")


def _open(path: Path) -> BinaryIO:
    return gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb")  # type: ignore[return-value] # a reader of bytes, too


def _fault(raw: bytes, where: str, columns: int) -> InputError | None:
    """Return the error of a damaged line, else None; the header has ``columns`` cells (0: the line is the header)."""
    try:
        line = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        got = f"byte 0x{error.object[error.start]:02x}"
        return InputError(where, expected="a text in UTF-8", got=got, todo="save it as UTF-8")
    if line.count('"') % 2:
        todo = "close the quote, or take it away: numbers need none"
        return InputError(where, expected="quotes in pairs", got="one that nothing closes", todo=todo)
    cells = _cells(line)
    if columns and cells > columns and line.rstrip().rstrip(","):
        return too_many_cells(where, columns, cells)
    return None


def _cells(line: str) -> int:
    """Count the cells of a line without an empty last one, which some programs write."""
    try:
        cells = next(csv.reader([line.strip()]), [])
    except csv.Error:  # a lone carriage return, or a cell longer than the library reads: the commas are counted
        cells = line.strip().split(",")
    return len(cells) - (len(cells) > 1 and not cells[-1])


def too_many_cells(where: str, columns: int, cells: int) -> InputError:
    """Return the error of a line with more ``cells`` than the ``columns`` of the header, mostly by decimal commas.

    Parameters
    ----------
    where
        File and line, for the message.
    columns
        Number of cells of the header.
    cells
        Number of cells of the line.

    Returns
    -------
    InputError
        For the caller to raise.
    """
    expected = f"{columns} cells, as the header has"
    return InputError(where, expected=expected, got=f"{cells}", todo=DECIMAL_COMMA)
