"""A figure that a set of real measurements is to reach: its aim, the published value and what was reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """One line of the table of aims.

    Parameters
    ----------
    name
        What is measured, in words.
    unit
        Unit of the numbers; empty for names of effects.
    aim
        Largest value that reaches the aim, or the effects of which one is to be named.
    reached
        Value reached, or the effects named; None where there is no result.
    published
        Published value of the same figure; None where there is none.
    """

    name: str
    unit: str
    aim: float | Sequence[str]
    reached: float | Sequence[str] | None
    published: float | None = None

    @property
    def met(self) -> bool | None:
        """Whether the aim is reached; None where there is no result."""
        if self.reached is None:
            return None
        if isinstance(self.aim, float):
            return isinstance(self.reached, float) and self.reached <= self.aim
        return not isinstance(self.reached, float) and bool(set(self.aim) & set(self.reached))

    def as_json(self) -> dict[str, Any]:
        """Return the line as JSON data."""
        return {
            "name": self.name,
            "unit": self.unit,
            "aim": self.aim if isinstance(self.aim, float) else list(self.aim),
            "reached": self.reached if self.reached is None or isinstance(self.reached, float) else list(self.reached),
            "published": self.published,
            "met": self.met,
        }
