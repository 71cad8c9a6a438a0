"""Exact linear dependence of rows of rational numbers, by SymPy's `DomainMatrix`.

Sparse rows go in; rank, reduced row echelon form and the combinations that make dependent rows come out. Rational
arithmetic has no rounding, so no tolerance decides on a rank.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from sympy import QQ
from sympy.polys.matrices import DomainMatrix

Row = dict[int, Fraction]
"""Sparse row: column → entry that is not zero."""


@dataclass(frozen=True, slots=True)
class Echelon:
    """Span of rows, held in reduced row echelon form.

    Parameters
    ----------
    reduced
        Pivot column, ascending → row with 1 in this column and 0 in the columns of the other pivots.
    """

    reduced: dict[int, Row]

    @classmethod
    def of(cls, rows: Iterable[Row]) -> Echelon:
        """Return the span of some rows.

        Parameters
        ----------
        rows
            Sparse rows, column → entry.

        Returns
        -------
        Echelon
            The span in reduced row echelon form.
        """
        matrix, pivots = _matrix(list(rows)).rref()
        return cls(dict(zip(pivots, _rows(matrix), strict=True)))

    @property
    def rank(self) -> int:
        """Number of independent rows."""
        return len(self.reduced)

    @property
    def columns(self) -> frozenset[int]:
        """The columns in which at least one row of the span is not zero."""
        return frozenset(column for row in self.reduced.values() for column in row)

    def extend(self, rows: Iterable[Row]) -> Echelon:
        """Return the span with further rows.

        Parameters
        ----------
        rows
            Further sparse rows, column → entry.

        Returns
        -------
        Echelon
            Span of the rows held and of those given.
        """
        return Echelon.of([*self.reduced.values(), *rows])


def combinations_of(rows: Sequence[Row]) -> list[Row | None]:
    """Express every row in those of the rows before it that are independent.

    Parameters
    ----------
    rows
        Sparse rows, column → entry.

    Returns
    -------
    list of (dict of int to Fraction, or None)
        Number of an independent row, from 0 in their order → factor in the exact combination that makes the row; None
        where the row is independent of those before it.
    """
    # With the rows as columns, the pivots are the independent rows, and each other column holds its combination.
    matrix, pivots = _matrix(rows).transpose().rref()
    found: list[Row | None] = [{} for _ in rows]
    for number, row in enumerate(_rows(matrix)):
        for place, factor in row.items():
            combination = found[place]
            if combination is not None:
                combination[number] = factor
        found[pivots[number]] = None
    return found


def _matrix(rows: Sequence[Row]) -> DomainMatrix:
    width = 1 + max((column for row in rows for column in row), default=-1)
    entries = {
        i: {column: QQ(value.numerator, value.denominator) for column, value in row.items() if value}
        for i, row in enumerate(rows)
    }
    return DomainMatrix({i: row for i, row in entries.items() if row}, (len(rows), width), QQ)


def _rows(matrix: DomainMatrix) -> list[Row]:
    """Return the rows of a matrix that are not zero."""
    return [
        {column: Fraction(int(value.numerator), int(value.denominator)) for column, value in sorted(row.items())}
        for _, row in sorted(matrix.rep.to_sdm().items())
    ]
