"""Checks of the parameters that a file states for a locked joint, in one place for devices and for campaigns.

An entry is ``{ initial, lower, upper, prior = { mean, std } }`` or ``{ fixed }``; a device's ``std`` is a prior about
``initial``. The checks are of sign, of size, of order, and of entries that contradict themselves or each other; the
bounds of a fit follow from entry and default range.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from haptid.model.equations.joint_parameters import DRIVE_TABLE, TABLE, Row
from haptid.model.friction.registry import laws
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import InputError

Entry = Mapping[str, Any]
ROWS: Mapping[str, Row] = {
    row.id: row for row in (*TABLE, *DRIVE_TABLE, *(row for law in laws().values() for row in law.parameters))
}
"""Rows of drive, body and spring, and of every friction law."""
ORDERED = tuple(dict.fromkeys(pair for law in laws().values() for pair in law.orderings))
"""Pairs of which the first is never smaller, as stiction and Coulomb friction."""


def check_parameters(stated: Mapping[str, Entry], where: Callable[[str], str]) -> None:
    """Check that fits and simulations can use the stated parameters of one joint.

    Parameters
    ----------
    stated
        Entries by the ids of `joint_parameters.TABLE`; their keys hold finite numbers, bounds may be infinite.
    where
        Id → place of the parameter in the user's file, as ``campaign.toml, line 12, joint.4.parameters.Fs``.

    Raises
    ------
    InputError
        At the first parameter at fault.
    """
    for id, entry in stated.items():
        _check_entry(ROWS[id], entry, where(id))
    for larger, smaller in ORDERED:
        if larger in stated and smaller in stated:
            _check_order(larger, smaller, stated, where(larger))


def possible_range(id: str) -> tuple[float, float]:
    """Return the range in which a stated number of a parameter must lie.

    Parameters
    ----------
    id
        Id of the parameter, with or without the number of its joint, as ``sigma0_1``.

    Returns
    -------
    tuple of float
        Default bounds widened by the factor `THRESHOLDS.largest_factor_beyond_range`, in the parameter's unit; the
        lower one of a positive parameter stays positive.
    """
    row = ROWS[id] if id in ROWS else ROWS[id.rpartition("_")[0]]
    beyond = THRESHOLDS.largest_factor_beyond_range
    return row.lower / beyond if row.lower > 0 else row.lower * beyond, row.upper * beyond


def possible_value(id: str, value: float) -> float:
    """Keep a number of a parameter within what a file may state.

    Parameters
    ----------
    id
        Id of the parameter.
    value
        Number in the parameter's unit.

    Returns
    -------
    float
        The nearest number in `possible_range`.
    """
    least, most = possible_range(id)
    return float(min(max(value, least), most))


def possible_guess(id: str, initial: float, lower: float, upper: float) -> dict[str, object]:
    """Keep a guess and its bounds within what a file may state: a result is read again by the same limits.

    Parameters
    ----------
    id
        Id of the parameter.
    initial, lower, upper
        Guess and bounds in the parameter's unit.

    Returns
    -------
    dict
        ``initial``, ``lower`` and ``upper``, each within `possible_range`.
    """
    values = {"initial": initial, "lower": lower, "upper": upper}
    return {key: possible_value(id, value) for key, value in values.items()}


def range_of(id: str, entry: Entry) -> tuple[float, float]:
    """Return the bounds of a parameter for a fit.

    Parameters
    ----------
    id
        Id of the parameter.
    entry
        Stated entry of the parameter; may be empty.

    Returns
    -------
    tuple of float
        The stated bounds, else the default ones, widened to contain the stated value; the fixed value twice where it is
        fixed. A lower bound of 0 on a positive parameter counts as none.
    """
    row, value = ROWS[id], stated_value(entry)
    if "fixed" in entry:
        return entry["fixed"], entry["fixed"]
    inside = [row.lower, row.upper] if value is None else [row.lower, row.upper, value]
    lower, upper = entry.get("lower", float("-inf")), entry.get("upper", float("inf"))
    highest = float(upper) if upper < float("inf") else max(inside)
    if _is_only_positive(row, entry):
        return min(inside) if min(inside) < highest else possible_range(id)[0], highest
    return float(lower) if lower > float("-inf") else min(inside), highest


def with_positive_bound(id: str, entry: Entry) -> dict[str, Any]:
    """Replace a lower bound of 0 on a parameter that is fitted as its logarithm by a positive bound.

    A bound of 0 says only that the parameter is positive.

    Parameters
    ----------
    id
        Id of the parameter.
    entry
        Stated entry of the parameter.

    Returns
    -------
    dict
        Copy of the entry, with the lower bound of `range_of` where the stated one is 0.
    """
    if _is_only_positive(ROWS[id], entry):
        return {**entry, "lower": range_of(id, entry)[0]}
    return dict(entry)


def stated_value(entry: Entry) -> float | None:
    """Return the value that an entry states.

    Parameters
    ----------
    entry
        Stated entry of a parameter.

    Returns
    -------
    float or None
        The fixed value, else the first guess, else the mean of the prior; None where the entry has bounds only.
    """
    for key in ("fixed", "initial"):
        if key in entry:
            return float(entry[key])
    return float(entry["prior"]["mean"]) if "prior" in entry else None


def _is_only_positive(row: Row, entry: Entry) -> bool:
    return row.lower > 0 and entry.get("lower") == 0


def _check_entry(row: Row, entry: Entry, where: str) -> None:
    if not entry:
        raise InputError(where, expected="initial, bounds, a prior or a fixed value", got="an empty table")
    if "fixed" in entry and len(entry) > 1:
        others = ", ".join(key for key in entry if key != "fixed")
        raise InputError(where, expected="fixed alone", got=f"fixed with {others}", todo="keep one of the two")
    prior = entry.get("prior", {})
    numbers = {**{key: entry[key] for key in ("fixed", "initial", "lower", "upper") if key in entry}, **prior}
    for key, value in numbers.items():
        if key == "lower" and _is_only_positive(row, entry):
            continue
        if key != "std" and abs(value) < float("inf"):
            _check_size(row, key, value, where)
    if "fixed" not in entry:
        _check_bounds(row, entry, numbers, where)
    std = prior.get("std", entry.get("std"))
    if std is not None:
        _check_width(row, std, stated_value({"prior": prior} if prior else entry), where)


def _check_bounds(row: Row, entry: Entry, numbers: Mapping[str, float], where: str) -> None:
    lower, upper = range_of(row.id, entry)
    if not lower < upper:
        todo = "fix it if it is known" if {"lower", "upper"} <= set(entry) else "state both bounds"
        raise InputError(where, expected="lower < upper", got=f"lower {lower:g}, upper {upper:g}", todo=todo)
    for key, words in (("initial", "an initial value"), ("mean", "a prior's mean")):
        if key in numbers and not lower <= numbers[key] <= upper:
            got = f"{key} {numbers[key]:g} outside [{lower:g}, {upper:g}]"
            raise InputError(where, expected=f"{words} within the bounds", got=got)


def _check_size(row: Row, key: str, value: float, where: str) -> None:
    least, most = possible_range(row.id)
    if least <= value <= most:
        return
    todo = "check its unit"
    if row.lower > 0 >= value:
        todo = "leave lower out if it is unknown" if key == "lower" else "it must be positive"
    elif key in ("lower", "upper"):
        todo = "leave the bound out if it is unknown"
    expected = f"{key} from {least:g} to {most:g} ({row.description}, SI units)"
    raise InputError(where, expected=expected, got=f"{value:g}", todo=todo)


def _check_width(row: Row, std: float, value: float | None, where: str) -> None:
    _, most = possible_range(row.id)
    least = THRESHOLDS.least_std_over_value * max(abs(value or 0.0), row.initial or 1e-3)
    if not least <= std <= most:
        todo = "write fixed for what is known" if std < least else "leave the prior out where nothing is known"
        expected = f"a standard deviation from {least:.1g} to {most:g}"
        raise InputError(where, expected=expected, got=f"{std:g}", todo=todo)


def _check_order(larger: str, smaller: str, stated: Mapping[str, Entry], where: str) -> None:
    values = stated_value(stated[larger]), stated_value(stated[smaller])
    highest, lowest = range_of(larger, stated[larger])[1], range_of(smaller, stated[smaller])[0]
    if values[0] is not None and values[1] is not None and values[0] < values[1]:
        got = f"{larger} = {values[0]:g}, {smaller} = {values[1]:g}"
    elif highest < lowest:
        got = f"{larger} up to {highest:g}, {smaller} from {lowest:g}"
    else:
        return
    names = f"{ROWS[larger].description}, {ROWS[smaller].description}"
    raise InputError(where, expected=f"{larger} >= {smaller} ({names})", got=got)
