"""What a command tells at its end: sentences and `Table`s in, plain text out.

`support.terminal` shows them on a terminal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Hold a table for a terminal, and the text that stands for it everywhere else.

    Parameters
    ----------
    header
        Headings of the columns.
    rows
        Cells by row, as many as headings.
    ruled
        Whether a rule stands below the headings of the plain text.
    plain
        Plain text where it is no table of aligned columns; None where it is.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    ruled: bool = False
    plain: str | None = None

    def __str__(self) -> str:
        """Return the plain text: left-aligned columns with two blanks between them, unless it was given."""
        if self.plain is not None:
            return self.plain
        lines = [self.header, *self.rows]
        widths = [max(len(row[column]) for row in lines) for column in range(len(self.header))]
        texts = []
        for row in lines:
            cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
            texts.append("  ".join(cells).rstrip())
        rule = ["-" * len(texts[0])] if self.ruled else []
        return "\n".join([texts[0], *rule, *texts[1:]])


Told = Sequence[str | Table]
"""Lines and tables in the order in which a reader gets them."""


def text_of(told: Told) -> str:
    """Write lines and tables as plain text.

    Parameters
    ----------
    told
        Lines and tables.

    Returns
    -------
    str
        One after the other, each from a new line.
    """
    return "\n".join(str(part) for part in told)
