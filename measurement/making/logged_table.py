"""Tables as loggers and spreadsheets write them: a CSV file of another layout in, `Table` out.

The campaign format has commas, decimal points and the header in the first line. Here semicolons, tabs, decimal commas,
lines before the header, a comment sign in front of it and Windows' encoding are understood as well.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import re
import tempfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from haptid.measurement.tables.layout import refuse_packed_bomb, refuse_repeated_names
from haptid.measurement.tables.table import OTHER_TEXT_SUFFIXES, TEXT_SUFFIXES, Table, read_table
from haptid.measurement.thresholds import THRESHOLDS
from haptid.support.errors import InputError
from haptid.support.files.files import read_content

SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas"}
OTHER_SEPARATORS = (";", "\t")
"""Those that the campaign format has not."""
BLANKS = " "
"""Separator of a text whose columns are set apart by blanks, as NumPy and MATLAB write them."""
TEXTS = OTHER_TEXT_SUFFIXES
"""Ends of texts that may be tables."""
NAME_IN_BLANKS = re.compile(r"\S+(?:\s?(?:\[[^\]]*\]|\([^)]*\)))?")
"""A name between blanks, with its unit in brackets."""
NUMBER = re.compile(r"\s*[+-]?((\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?|nan|inf)\s*", re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*")
MAY_BE_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}(,\d{3})+\s*")
GZIP = b"\x1f\x8b"
"""First bytes of what gzip has packed."""
MOST_LINES_BEFORE_HEADER = 100
"""Lines that a logger writes about itself before the header, at most."""
ROWS_THAT_SHOW_LAYOUT = 3
"""Rows after a header that have to hold as many cells as it does."""
FEWEST_COLUMNS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """How a file is laid out.

    Parameters
    ----------
    separator
        Sign between the cells.
    header
        Number of the header's line, from 0.
    decimal_comma
        Whether numbers have decimal commas.
    commented
        Whether a comment sign stands before the header.
    units
        Whether the line is one of units, with the names in the line before it.
    """

    separator: str
    header: int
    decimal_comma: bool
    commented: bool
    units: bool

    @property
    def words(self) -> str:
        """What differs from the campaign format, in words; empty where nothing does."""
        spare = self.header - self.units
        before = f"{spare} line{'s' * (spare > 1)} before the header"
        parts = [
            SEPARATORS.get(self.separator, "blanks") if self.separator != "," else "",
            "decimal commas" if self.decimal_comma else "",
            before if spare else "",
            "a line of units" if self.units else "",
            "a comment sign before the header" if self.commented else "",
        ]
        return ", ".join(part for part in parts if part)


def read_logged_table(path: Path) -> tuple[Table, str]:
    """Read a table of any layout that can be told with certainty.

    Parameters
    ----------
    path
        File that ends in ``.csv``, ``.csv.gz``, ``.parquet`` or as a text; all but Parquet may have another layout.

    Returns
    -------
    table : Table
        With its cells as text; errors name the lines of the file.
    layout : str
        What of the layout was understood, in words; empty where the file has that of the campaign format.

    Raises
    ------
    InputError
        As `read_table`; also where the rows are too few to tell the separator.
    """
    is_text = path.name.endswith(TEXTS)
    if not (is_text or path.name.endswith(TEXT_SUFFIXES)):
        return read_table(path, as_text=True), ""
    content = _unpacked(path)
    text = _decode(content)
    lines = text.splitlines()
    layout = find_layout(lines, blanks=is_text)
    if layout is None:
        _refuse_few_rows(path, [line for line in lines if line.strip()])
    if layout is None or (not is_text and not layout.words and text == content.decode("utf-8-sig", errors="ignore")):
        return read_table(path, as_text=True), ""
    names = _header_names(lines, layout)
    refuse_repeated_names(f"{path}, line {layout.header + 1}", names)
    rewritten = _rewrite(names, lines, layout)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / f"{path.name.removesuffix('.csv.gz') if path.suffix == '.gz' else path.stem}.csv"
        copy.write_text(rewritten, encoding="utf-8")
        try:
            table = read_table(copy, as_text=True)
        except InputError as error:
            where = error.where.replace(str(copy), str(path))
            raise InputError(where, expected=error.expected, got=error.got, todo=error.todo) from None
    name, preamble = copy.name if is_text else "", tuple(lines[: layout.header])
    return replace(table, path=path, lines_before=layout.header, file=name, preamble=preamble), layout.words


def _unpacked(path: Path) -> bytes:
    """Return what a text holds, packed or not."""
    content = read_content(path, "a table of a run")
    if path.suffix != ".gz":
        if content.startswith(GZIP):
            raise InputError(str(path), expected="a table of a run", got="one packed by gzip", todo="name it .csv.gz")
        return content
    try:
        refuse_packed_bomb(path)
        return gzip.decompress(content)
    except (OSError, EOFError, zlib.error) as error:
        got = f"a damaged archive ({type(error).__name__})"
        raise InputError(str(path), expected="a table of a run", got=got, todo="export it again") from None


def _refuse_few_rows(path: Path, lines: Sequence[str]) -> None:
    """Refuse a file with so few rows that its separator is not certain; it has too few rows whatever that is."""
    rows = len(lines) - 1
    separated = any(len(_names(lines[0], sign)) >= FEWEST_COLUMNS for sign in OTHER_SEPARATORS) if lines else False
    if separated and rows < ROWS_THAT_SHOW_LAYOUT:
        raise InputError(str(path), expected=f"at least {THRESHOLDS.least_rows_of_table} rows", got=f"{rows}")


def is_table(path: Path) -> bool:
    """Whether a text holds a table: a line of names with rows of as many numbers below it.

    Parameters
    ----------
    path
        File that ends as a text.

    Returns
    -------
    bool
    """
    return find_layout(_decode(read_content(path, "a text")).splitlines(), blanks=True) is not None


def _decode(content: bytes) -> str:
    """Return the text of a file in UTF-8, in UTF-16 that says so, or in that of Windows, in which ° is one byte."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def find_layout(lines: Sequence[str], *, blanks: bool = False) -> Layout | None:
    """Find header, separator and decimal sign: a line of names with rows of as many numbers below it.

    Parameters
    ----------
    lines
        Lines of the file.
    blanks
        Whether blanks may set columns apart.

    Returns
    -------
    Layout or None
        None where no line is certain to be the header.
    """
    for header in range(min(len(lines), MOST_LINES_BEFORE_HEADER)):
        for separator in (*SEPARATORS, *(BLANKS if blanks else "")):
            layout = _layout_at(lines, header, separator)
            if layout is not None:
                return layout
    return None


def _layout_at(lines: Sequence[str], header: int, separator: str) -> Layout | None:
    """Return the layout where line ``header`` is the header with this separator."""
    names = _names(lines[header], separator)
    rows = [_cells(line, separator) for line in lines[header + 1 : header + 1 + ROWS_THAT_SHOW_LAYOUT]]
    if len(names) < FEWEST_COLUMNS or len(rows) < ROWS_THAT_SHOW_LAYOUT or _numbers_in(names):
        return None
    if any(len(row) != len(names) or _numbers_in(row) < FEWEST_COLUMNS for row in rows):
        return None
    before = _names(lines[header - 1], separator) if header else []
    cells = [cell for row in rows for cell in row]
    with_comma = [cell for cell in cells if DECIMAL_COMMA.fullmatch(cell)]
    # Between commas only a quoted cell holds one, as spreadsheets write it, and it may part thousands.
    decimal_comma = separator != "," or any(not MAY_BE_THOUSANDS.fullmatch(cell) for cell in with_comma)
    return Layout(
        separator=separator,
        header=header,
        decimal_comma=bool(with_comma) and decimal_comma,
        commented=lines[header].lstrip().startswith(("#", "%")),
        units=len(before) == len(names) and not _numbers_in(before),
    )


def _numbers_in(cells: Sequence[str]) -> int:
    return sum(NUMBER.fullmatch(cell) is not None for cell in cells)


def _names(line: str, separator: str) -> list[str]:
    """Return the cells of a header; between blanks a unit in brackets belongs to the name before it."""
    text = line.lstrip("#% ")
    return NAME_IN_BLANKS.findall(text) if separator == BLANKS else _cells(text, separator)


def _cells(line: str, separator: str) -> list[str]:
    if separator == BLANKS:
        return line.split()
    return next(csv.reader([line], delimiter=separator), [])


def _header_names(lines: Sequence[str], layout: Layout) -> list[str]:
    """Return the names of the columns; a unit stands behind its name."""
    names = _names(lines[layout.header], layout.separator)
    if not layout.units:
        return names
    first = _names(lines[layout.header - 1], layout.separator)
    return [f"{name.strip()} {unit.strip()}".strip() for name, unit in zip(first, names, strict=True)]


def _rewrite(names: Sequence[str], lines: Sequence[str], layout: Layout) -> str:
    """Return names and rows with commas and decimal points."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(names)
    for line in lines[layout.header + 1 :]:
        cells = _cells(line, layout.separator)
        if layout.decimal_comma:
            cells = [cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell for cell in cells]
        writer.writerow(cells)
    return stream.getvalue()
