"""Check values that a file states: value and `Possible` range in, nothing out or an `InputError`.

Checked are sign and size, the value's own bounds, its unit, and the order of pairs as Fs ≥ Fc.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from haptid.fmu_build.description.units import parse_unit
from haptid.fmu_build.thresholds import THRESHOLDS
from haptid.model.device.stated_parameters import ROWS, possible_range
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity
from haptid.support.errors import InputError

BODY = {
    "m": (0.0, 1e6), "J": (0.0, 1e6), **dict.fromkeys("xyz", (-1e3, 1e3)),
    **dict.fromkeys(("I11", "I22", "I33"), (0.0, 1e9)), **dict.fromkeys(("I12", "I13", "I23"), (-1e9, 1e9)),
}  # fmt: skip
"""Ranges of the standard parameters of links and rotors, beyond those of any machine [kg, m, kg m^2]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Possible:
    """Say which values a quantity can have.

    Parameters
    ----------
    least, most
        Range of the value in SI units, bounds included.
    units
        Units in which a file may state the value.
    description
        Name of the quantity, for errors.
    """

    least: float
    most: float
    units: tuple[str, ...]
    description: str


def of_joint_parameter(id: str, *, slides: bool | None = None) -> Possible:
    """Return the possible values of a parameter of a locked joint.

    Parameters
    ----------
    id
        Plain id, a key of `ROWS`.
    slides
        Whether the joint is prismatic; None where that is unknown, which allows the units of both kinds.

    Returns
    -------
    Possible
        Range by `possible_range`.
    """
    row, (least, most) = ROWS[id], possible_range(id)
    units = {None: (row.unit, row.prismatic_unit), True: (row.prismatic_unit,), False: (row.unit,)}[slides]
    return Possible(least=least, most=most, units=units, description=row.description)


def of_quantity(q: Quantity) -> Possible:
    """Return the possible values of a parameter of a link, a rotor or an effect.

    Parameters
    ----------
    q
        Parameter; its id says whether it belongs to a link (``link6_m``) or a rotor (``motor_<name>_J``).

    Returns
    -------
    Possible
        `BODY` for links and rotors. For an effect, magnitudes up to 1e15 with the sign that its scale and its lower
        bound imply: bounds themselves may be multiples of a scale that a file does not state.
    """
    least, most = -THRESHOLDS.largest_magnitude_si, THRESHOLDS.largest_magnitude_si
    if q.id.startswith(("link", "motor_")):
        least, most = BODY[q.id.rpartition("_")[2]]
    elif q.scale == "log":
        least = 1 / THRESHOLDS.largest_magnitude_si**2  # above 0, as its logarithm is fitted
    elif q.lower >= 0:
        least = 0.0
    return Possible(least=least, most=most, units=(q.unit,), description=q.description)


def check_value(value: float, possible: Possible, where: str) -> None:
    """Refuse a value outside its possible range.

    Parameters
    ----------
    value
        In SI units; NaN is refused, too.
    possible
        Range and name of the quantity.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        With the range.
    """
    if not possible.least <= value <= possible.most:
        expected = f"a number from {possible.least:g} to {possible.most:g} ({possible.description}, SI units)"
        raise InputError(where, expected=expected, got=f"{value:g}")


def check_entry(entry: Mapping[str, Any], possible: Possible, where: str) -> None:
    """Refuse an entry that contradicts its quantity or itself.

    Parameters
    ----------
    entry
        ``{value, unit, lower, upper}``; all but ``value`` are optional, and an empty unit is any unit.
    possible
        Range, units and name of the quantity.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        With the value, the unit or the bounds at fault.
    """
    value = float(entry["value"])
    check_value(value, possible, f"{where}.value")
    if not any(same_unit(entry.get("unit", ""), unit) for unit in possible.units):
        expected = f"the unit {' or '.join(dict.fromkeys(possible.units))}"
        at, todo = f"{where}.unit", "values are in SI units"
        raise InputError(at, expected=expected, got=repr(entry["unit"]), todo=todo)
    check_bounds(entry, where)


def check_bounds(entry: Mapping[str, Any], where: str) -> None:
    """Refuse an entry ``{value, lower, upper}`` with lower > upper, or a value that lies outside by more than rounding.

    Parameters
    ----------
    entry
        ``{value, lower, upper}``; a bound that is absent or None is infinite.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        At ``where``, file and key.
    """
    value = float(entry["value"])
    lower = -math.inf if entry.get("lower") is None else float(entry["lower"])
    upper = math.inf if entry.get("upper") is None else float(entry["upper"])
    if lower > upper:
        raise InputError(where, expected="lower <= upper", got=f"lower {lower:g}, upper {upper:g}")
    excess = THRESHOLDS.largest_excess_over_bound
    below, above = lower - excess * abs(lower), upper + excess * abs(upper)
    if value < below or value > above:
        got = f"{value:g} outside [{lower:g}, {upper:g}]"
        at = f"{where}.value"
        raise InputError(at, expected="a value within its bounds", got=got)


def check_order(
    larger: str, smaller: str, values: Mapping[str, float], guesses: Mapping[str, float], where: str
) -> None:
    """Refuse values with which no simulation starts, as Fs below Fc by more than 1e-4 of it.

    Parameters
    ----------
    larger, smaller
        Ids of the pair; nothing is checked where one has neither value nor guess.
    values
        Stated value by id, SI units.
    guesses
        First guess by id, for values that are not stated.
    where
        File and key, for errors.

    Raises
    ------
    InputError
        With both values; the remedy names the one that is a first guess.
    """
    a, b = (float(values.get(id, guesses.get(id, math.nan))) for id in (larger, smaller))
    if a < b - THRESHOLDS.largest_shortfall_of_stiction * abs(b):
        guessed = [id for id in (larger, smaller) if id not in values]
        todo = f"{guessed[0]} is a first guess: state it, too" if guessed else ""
        raise InputError(
            where, expected=f"{larger} >= {smaller}", got=f"{larger} = {a:g}, {smaller} = {b:g}", todo=todo
        )


def same_unit(text: str, unit: str) -> bool:
    """Return whether two texts are the same unit, by SI exponents and factor.

    Parameters
    ----------
    text
        Unit that a file states; an empty one is the same as any.
    unit
        Unit of the quantity.

    Returns
    -------
    bool
        False where ``text`` is no known unit.

    Examples
    --------
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


def with_pairs_in_order(
    values: Mapping[str, float], equations: Equations, where: str, *, of_fit: bool = False
) -> dict[str, float]:
    """Return values whose pairs are in order to the last bit, as an FMU requires.

    Parameters
    ----------
    values
        Stated value by id, SI units; the first guess where absent.
    equations
        Equations with the orderings, as Fs ≥ Fc.
    where
        What states the values, for errors.
    of_fit
        Whether a fit found the values, and nobody states them: one that explains nothing may pass its constraints far.

    Returns
    -------
    dict
        A fit that ends at a constraint may return Fs below Fc by as much as its minimiser passes it; Fs becomes Fc.

    Raises
    ------
    InputError
        Where a pair of stated values is out of order by more than `THRESHOLDS.largest_shortfall_of_stiction`.
    """
    guesses = {q.id: q.initial for q in equations.parameters}
    ordered = dict(values)
    for larger, smaller in equations.orderings:
        if not of_fit:
            check_order(larger, smaller, ordered, guesses, where)
        a, b = (ordered.get(id, guesses[id]) for id in (larger, smaller))
        if a < b:
            ordered[larger] = b
    return ordered
