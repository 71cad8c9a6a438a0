"""All thresholds of the product by room, and what half and twice of each is.

The modules of thresholds are imported here and nothing that reads them: a process changes a value before its readers
are loaded, because some of them take it over as they load.
"""

from __future__ import annotations

import ast
import inspect
from dataclasses import dataclass, fields
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any

Value = int | float | tuple["Value", ...]
FACTORS = MappingProxyType({"halved": 0.5, "doubled": 2.0})
SHARES = ("share", "p_value", "probability", "power", "coverage", "least_p_of")
"""Parts of the names of thresholds that are shares or probabilities, where their value is one."""
DISCREPANCY = ("study", "fit", "detect", "torque", "candidate", "search", "unnamed", "verdict", "finding")
ROOMS = (
    *("model", "measurement", "fmu_build", "noise", "identification", "uq"),
    *(f"discrepancy.{room}" for room in DISCREPANCY),
)
"""Rooms that have thresholds, in the order in which their modules may be loaded."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Threshold:
    """A number that decides an outcome.

    Parameters
    ----------
    room
        One of `ROOMS`.
    name
        Of the field.
    value
        As delivered.
    meaning
        First sentence of the docstring.
    """

    room: str
    name: str
    value: Value
    meaning: str

    @property
    def key(self) -> str:
        """Room and name, ``noise.most_lines``."""
        return f"{self.room}.{self.name}"

    def scale_value(self, change: str) -> Value | None:
        """Halve or double the threshold, within what it can mean.

        Parameters
        ----------
        change
            ``halved`` or ``doubled``.

        Returns
        -------
        int, float, tuple or None
            New value, see `scale`; None where that is the value itself.
        """
        new = scale(self.value, FACTORS[change], is_share=any(part in self.name for part in SHARES))
        return None if new == self.value else new

    def as_json(self) -> dict[str, Any]:
        """Convert to an entry of ``thresholds`` in the study's JSON.

        Returns
        -------
        dict
            The fields by name, and both changed values, ``halved`` and ``doubled``.
        """
        both = {change: self.scale_value(change) for change in FACTORS}
        return {"room": self.room, "name": self.name, "meaning": self.meaning, "value": self.value, **both}


def scale(value: Value, factor: float, *, is_share: bool = False) -> Value:
    """Return a value times a factor, within what it can mean.

    Parameters
    ----------
    value
        Number, or several that are scaled together.
    factor
        Positive number [1].
    is_share
        Whether the value is a share or a probability, if it lies between 0 and 1.

    Returns
    -------
    int, float or tuple
        Counts are whole and at least 1. Where a share would reach 1, its distance to 1 is divided by the factor.

    Examples
    --------
    >>> scale(5, 0.5), scale(1, 0.5), scale(0.95, 2.0, is_share=True), scale((1.0, 3), 2.0)
    (2, 1, 0.975, (2.0, 6))
    """
    if isinstance(value, tuple):
        return tuple(scale(each, factor, is_share=is_share) for each in value)
    if isinstance(value, int):
        return max(1, round(value * factor))
    if is_share and 0.0 < value < 1.0 <= value * factor:
        return 1.0 - (1.0 - value) / factor
    return value * factor


def room_values(room: str) -> Any:
    """Return the frozen values that the readers of a room share.

    Parameters
    ----------
    room
        One of `ROOMS`; its module and those that it is made from are loaded.

    Returns
    -------
    Thresholds
        The object itself, not a copy.
    """
    package, _, inner = room.partition(".")
    module = f"haptid.{package}.thresholds" + (".thresholds" if inner else "")
    found = import_module(module).THRESHOLDS
    return getattr(found, inner) if inner else found


@cache
def all_thresholds() -> tuple[Threshold, ...]:
    """List every threshold of every room as delivered.

    Returns
    -------
    tuple of Threshold
        In the order of the code.
    """
    found = []
    for room in ROOMS:
        values = room_values(room)
        told = _meanings(type(values))
        found += [
            Threshold(room=room, name=f.name, value=getattr(values, f.name), meaning=told.get(f.name, f.name))
            for f in fields(values)
        ]
    return tuple(found)


def _meanings(owner: type) -> dict[str, str]:
    """Read the docstrings below the fields of a class, the first sentence of each."""
    (body,) = ast.parse(inspect.getsource(owner)).body
    told: dict[str, str] = {}
    name = ""
    for line in body.body if isinstance(body, ast.ClassDef) else ():
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
            name = line.target.id
        elif isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant) and name:
            told[name] = " ".join(str(line.value.value).split()).split(". ")[0].rstrip(".")
            name = ""
    return told
