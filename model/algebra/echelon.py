"""Exact linear dependence of rows of rational numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

Row = dict[int, Fraction]
"""Sparse row: column → entry that is not zero."""


@dataclass(slots=True)
class Echelon:
    """Rows in echelon form, each remembered as a combination of the independent rows that were added.

    `add` returns None for a row that is independent of the earlier ones, else its exact combination of them.
    """

    _rows: dict[int, tuple[Row, Row]] = field(default_factory=dict)
    rank: int = 0

    def add(self, row: Mapping[int, Fraction]) -> Row | None:
        """Add a row; return its combination {number of an independent row: factor} where it depends on them."""
        left, combination = self.reduce(row)
        if not left:
            return combination
        pivot = min(left)
        lead = left[pivot]
        origin = {number: -factor / lead for number, factor in combination.items()}
        origin[self.rank] = 1 / lead
        self._rows[pivot] = ({column: value / lead for column, value in left.items()}, origin)
        self.rank += 1
        return None

    def reduce(self, row: Mapping[int, Fraction]) -> tuple[Row, Row]:
        """Return what of the row is outside the span, and the combination of independent rows that makes the rest."""
        left = {column: value for column, value in row.items() if value}
        combination: Row = {}
        for pivot in sorted(self._rows):
            factor = left.get(pivot)
            if factor:
                basis, origin = self._rows[pivot]
                _subtract(left, factor, basis)
                _subtract(combination, -factor, origin)
        return left, combination

    @property
    def columns(self) -> frozenset[int]:
        """The columns in which some row is not zero."""
        return frozenset(column for row, _ in self._rows.values() for column in row)

    def reduced(self) -> dict[int, Row]:
        """Return the reduced row echelon form: pivot column → row with 1 there and 0 in the other pivots' columns."""
        result: dict[int, Row] = {}
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
        """Tell whether the row is a combination of those added."""
        return not self.reduce(row)[0]


def _subtract(target: Row, factor: Fraction, row: Row) -> None:
    for column, value in row.items():
        result = target.get(column, Fraction(0)) - factor * value
        if result:
            target[column] = result
        else:
            target.pop(column, None)
