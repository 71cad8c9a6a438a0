"""Exact linear dependence of rows of rational numbers, by Gaussian elimination.

Sparse rows come in one at a time; rank, span, reduced row echelon form and the combination that makes a dependent row
go out. Rational arithmetic has no rounding, so no tolerance decides on a rank.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

Row = dict[int, Fraction]
"""Sparse row: column → entry that is not zero."""


@dataclass(slots=True)
class Echelon:
    """Rows in echelon form, each stored with its combination of the independent rows that were added.

    Parameters
    ----------
    rank
        Number of independent rows so far; independent rows are numbered from 0 in the order of their addition.
    """

    _rows: dict[int, tuple[Row, Row]] = field(default_factory=dict)
    rank: int = 0

    def add(self, row: Mapping[int, Fraction]) -> Row | None:
        """Add a row.

        Parameters
        ----------
        row
            Sparse row, column → entry.

        Returns
        -------
        dict of int to Fraction or None
            Number of an earlier independent row → factor in the exact combination that makes the row; None where the
            row is independent of the earlier ones.
        """
        left, combination = self.reduce(row)
        if not left:
            return combination
        pivot = min(left)
        lead = left[pivot]
        # scaled to 1 at the pivot: stored row = (row − combination of the earlier rows)/lead
        origin = {number: -factor / lead for number, factor in combination.items()}
        origin[self.rank] = 1 / lead
        self._rows[pivot] = ({column: value / lead for column, value in left.items()}, origin)
        self.rank += 1
        return None

    def reduce(self, row: Mapping[int, Fraction]) -> tuple[Row, Row]:
        """Split a row into its remainder outside the span and its part inside the span.

        Parameters
        ----------
        row
            Sparse row, column → entry.

        Returns
        -------
        remainder
            Sparse row after elimination; empty where the row lies in the span.
        combination
            Number of an independent row → factor; the combination makes the row without the remainder.
        """
        left = {column: value for column, value in row.items() if value}
        combination: Row = {}
        # ascending pivots: a stored row has no entry left of its pivot, so that no eliminated column comes back
        for pivot in sorted(self._rows):
            factor = left.get(pivot)
            if factor:
                basis, origin = self._rows[pivot]
                _subtract(left, factor, basis)
                _subtract(combination, -factor, origin)
        return left, combination

    @property
    def columns(self) -> frozenset[int]:
        """The columns in which at least one row of the span is not zero."""
        return frozenset(column for row, _ in self._rows.values() for column in row)

    def reduce_rows(self) -> dict[int, Row]:
        """Return the reduced row echelon form.

        Returns
        -------
        dict of int to Row
            Pivot column, ascending → row with 1 in this column and 0 in the columns of the other pivots.
        """
        result: dict[int, Row] = {}
        # from the last pivot back: the rows in ``result`` are already reduced when they are subtracted
        for pivot in sorted(self._rows, reverse=True):
            row = dict(self._rows[pivot][0])
            for other, lower in result.items():
                if other in row:
                    _subtract(row, row[other], lower)
            result[pivot] = row
        return dict(sorted(result.items()))

    def copy(self) -> Echelon:
        """Return an independent copy."""
        return Echelon(dict(self._rows), self.rank)

    def spans(self, row: Mapping[int, Fraction]) -> bool:
        """Return whether a row lies in the span of the added rows."""
        return not self.reduce(row)[0]


def _subtract(target: Row, factor: Fraction, row: Row) -> None:
    for column, value in row.items():
        result = target.get(column, Fraction(0)) - factor * value
        if result:
            target[column] = result
        else:
            target.pop(column, None)
