"""Whether a value that a file states can be that of the quantity it becomes: sign, size, bounds, unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from haptid.fmu_build.description.units import parse_unit
from haptid.model.device.stated_parameters import ROWS, possible_range
from haptid.model.equations.quantity import Quantity
from haptid.support.errors import InputError

LARGEST = 1e15
"""Size of a number that no machine's parameter has, in any SI unit, where no closer range is known."""
ROUNDING = 1e-9
"""How far a value may lie beyond its bounds, relative to them: a fit works with its logarithm."""
MEETING = 1e-4
"""How far Fs may lie below Fc, relative to it: a minimiser passes a constraint at which it ends by as much."""
BODY = {
    "m": (0.0, 1e6), "J": (0.0, 1e6), **dict.fromkeys("xyz", (-1e3, 1e3)),
    **dict.fromkeys(("I11", "I22", "I33"), (0.0, 1e9)), **dict.fromkeys(("I12", "I13", "I23"), (-1e9, 1e9)),
}  # fmt: skip
"""Ranges of the standard parameters of links and rotors, beyond those of any machine [kg, m, kg m^2]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Possible:
    """The range in which a quantity's value makes sense, the units in which it may be stated, and what it is."""

    least: float
    most: float
    units: tuple[str, ...]
    description: str


def of_joint_parameter(id: str, *, slides: bool | None = None) -> Possible:
    """Return what a parameter of a locked joint can be; None where it is not known whether the joint slides."""
    row, (least, most) = ROWS[id], possible_range(id)
    units = {None: (row.unit, row.prismatic_unit), True: (row.prismatic_unit,), False: (row.unit,)}[slides]
    return Possible(least=least, most=most, units=units, description=row.description)


def of_quantity(q: Quantity) -> Possible:
    """Return what a parameter of a link, a rotor or an effect can be: of an effect, its sign and at most `LARGEST`."""
    least, most = -LARGEST, LARGEST
    if q.id.startswith(("link", "motor_")):
        least, most = BODY[q.id.rpartition("_")[2]]
    elif q.scale == "log":
        least = 1 / LARGEST**2
    elif q.lower >= 0:
        least = 0.0
    return Possible(least=least, most=most, units=(q.unit,), description=q.description)


def check_value(value: float, possible: Possible, where: str) -> None:
    """Refuse a value outside its possible range; ``where`` names file and key."""
    if not possible.least <= value <= possible.most:
        expected = f"a number from {possible.least:g} to {possible.most:g} ({possible.description}, SI units)"
        raise InputError(where, expected=expected, got=f"{value:g}")


def check_entry(entry: Mapping[str, Any], possible: Possible, where: str) -> None:
    """Refuse an entry ``{value, unit, lower, upper}`` that contradicts its quantity or itself."""
    value = float(entry["value"])
    check_value(value, possible, f"{where}.value")
    if not any(same_unit(entry.get("unit", ""), unit) for unit in possible.units):
        expected = f"the unit {' or '.join(dict.fromkeys(possible.units))}"
        at, todo = f"{where}.unit", "values are in SI units"
        raise InputError(at, expected=expected, got=repr(entry["unit"]), todo=todo)
    check_bounds(entry, where)


def check_bounds(entry: Mapping[str, Any], where: str) -> None:
    """Refuse bounds in the wrong order, and a value that does not lie between them."""
    value = float(entry["value"])
    lower = -math.inf if entry.get("lower") is None else float(entry["lower"])
    upper = math.inf if entry.get("upper") is None else float(entry["upper"])
    if lower > upper:
        raise InputError(where, expected="lower <= upper", got=f"lower {lower:g}, upper {upper:g}")
    below, above = lower - ROUNDING * abs(lower), upper + ROUNDING * abs(upper)
    if value < below or value > above:
        got = f"{value:g} outside [{lower:g}, {upper:g}]"
        at = f"{where}.value"
        raise InputError(at, expected="a value within its bounds", got=got)


def check_order(
    larger: str, smaller: str, values: Mapping[str, float], guesses: Mapping[str, float], where: str
) -> None:
    """Refuse values with which no simulation starts: Fs below Fc; ``guesses`` stand where none is stated."""
    a, b = (float(values.get(id, guesses.get(id, math.nan))) for id in (larger, smaller))
    if a < b - MEETING * abs(b):
        guessed = [id for id in (larger, smaller) if id not in values]
        todo = f"{guessed[0]} is a first guess: state it, too" if guessed else ""
        raise InputError(
            where, expected=f"{larger} >= {smaller}", got=f"{larger} = {a:g}, {smaller} = {b:g}", todo=todo
        )


def same_unit(text: str, unit: str) -> bool:
    """Whether a text names ``unit``; an empty one leaves it open.

    >>> same_unit("kg m^2/s^2", "N m"), same_unit("N m/deg", "N m/rad"), same_unit("", "m")
    (True, False, True)
    """
    if text in {"", unit}:
        return True
    try:
        one, other = parse_unit(text), parse_unit(unit)
    except (ValueError, OverflowError):
        return False
    return one.exponents == other.exponents and one.factor == other.factor
