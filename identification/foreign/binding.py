"""What a campaign says of an FMU's variables against what the FMU has: both in, checked `Quantity`s out.

1. Inputs are the FMU's inputs, outputs hold numbers.
2. Parameters are real numbers that can be set before initialisation, their ranges within the FMU's own.
3. Start values of the runs can be set, and are no parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from haptid.identification.foreign.process import ForeignFmu
from haptid.identification.foreign.variables import REAL, Variable
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.foreign_campaign import ForeignCampaign
from haptid.model.equations.quantity import Normal, Quantity
from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

MOST_LISTED = 8
"""Variables that an error lists."""


def quantities_of(campaign: ForeignCampaign, fmu: ForeignFmu) -> tuple[Quantity, ...]:
    """Check all names of a campaign and return its parameters.

    Parameters
    ----------
    campaign
        As `read_foreign_campaign` returns it.
    fmu
        The FMU, unpacked.

    Returns
    -------
    tuple of Quantity
        In the order of ``campaign.toml``; ``structured`` is the variable's name. A positive parameter whose bounds are
        an order of magnitude apart moves in its logarithm.

    Raises
    ------
    InputError
        Where the FMU has no such variable, a variable cannot play its part, or numbers contradict the FMU's range.
    """
    _check_signals(campaign, fmu)
    _check_starts(campaign, fmu)
    return tuple(_parameter(campaign, fmu, name) for name in campaign.parameters)


def _check_signals(campaign: ForeignCampaign, fmu: ForeignFmu) -> None:
    for name in campaign.inputs:
        variable = _find_variable(fmu, name, campaign.place("inputs", name), "input")
        if variable.causality != "input" or not variable.scalar:
            _refuse(fmu, variable, campaign.place("inputs", name), "an input that holds a number", "input")
    for name in campaign.outputs:
        variable = _find_variable(fmu, name, campaign.place("outputs", name), "output")
        if not variable.scalar:
            _refuse(fmu, variable, campaign.place("outputs", name), "a variable that holds a number", "output")


def _parameter(campaign: ForeignCampaign, fmu: ForeignFmu, name: str) -> Quantity:
    where, entry = campaign.place("parameters", name), campaign.parameters[name]
    variable = _find_variable(fmu, name, where, "parameter")
    if not (variable.is_settable and variable.scalar):
        _refuse(fmu, variable, where, "a variable that can be set before initialisation", "parameter")
    if variable.type not in REAL and "fixed" not in entry:
        _refuse(fmu, variable, where, "a real number, or { fixed = … }", "parameter")
    if name in campaign.inputs:
        raise InputError(where, expected="a parameter that is no input", got=f"{name} under [inputs], too")
    return _quantity(variable, entry, where)


def _check_starts(campaign: ForeignCampaign, fmu: ForeignFmu) -> None:
    for file, start in campaign.starts.items():
        where = campaign.place("runs", file)
        for name in start:
            variable = _find_variable(fmu, name, where, "parameter")
            if not (variable.is_settable and variable.scalar):
                _refuse(fmu, variable, where, "a variable that can be set before initialisation", "parameter")
            if name in campaign.parameters:
                got = f"{name} under [parameters], too"
                raise InputError(where, expected="start values that are no parameters", got=got)


def _find_variable(fmu: ForeignFmu, name: str, where: str, part: str) -> Variable:
    if name in fmu.variables:
        return fmu.variables[name]
    todo = did_you_mean(name, fmu.variables)
    todo = todo if todo.startswith("did") else _list_variables(fmu, part)
    raise InputError(where, expected=f"a variable of {fmu.path.name}", got=repr(name), todo=todo)


def _refuse(fmu: ForeignFmu, variable: Variable, where: str, expected: str, part: str) -> None:
    got = f"{variable.name}, {variable.kind}" if variable.scalar else f"{variable.name}, which is no single number"
    raise InputError(where, expected=expected, got=got, todo=_list_variables(fmu, part))


def _list_variables(fmu: ForeignFmu, part: str) -> str:
    """Say which variables can play a part: ``input``, ``output`` or ``parameter``."""
    fits = [v.name for v in fmu.variables.values() if v.scalar and _can_be(v, part)]
    shown = ", ".join(fits[:MOST_LISTED]) + (", …" if len(fits) > MOST_LISTED else "")
    return f"it has the {part}s {shown}" if fits else f"it has no {part}s"


def _can_be(variable: Variable, part: str) -> bool:
    if part == "parameter":
        return variable.is_settable and variable.type in REAL and variable.causality != "input"
    return variable.causality == part


def _quantity(variable: Variable, entry: Mapping[str, Any], where: str) -> Quantity:
    lower, upper = _range(variable, entry, where)
    if "fixed" in entry:
        value = float(entry["fixed"])
        if not lower <= value <= upper:
            raise InputError(where, expected=f"a value in [{lower:g}, {upper:g}], as the FMU says", got=f"{value:g}")
        return _make_quantity(variable, initial=value, fixed=True)
    told = entry.get("prior")
    prior = None if told is None else Normal(mean=float(told["mean"]), std=float(told["std"]))
    stated = entry.get("initial", prior.mean if prior else variable.start)
    if stated is None:
        todo = "write { initial = … }"
        raise InputError(where, expected="a first guess", got="none, neither here nor in the FMU", todo=todo)
    initial = float(stated)
    if not lower <= initial <= upper:
        whose = "first guess" if "initial" in entry else "the FMU's start value"
        expected, todo = f"a first guess in [{lower:g}, {upper:g}]", "write { initial = … }, or widen the bounds"
        raise InputError(where, expected=expected, got=f"{whose} {initial:g}", todo=todo)
    logarithmic = lower > 0 and upper >= THRESHOLDS.least_logarithmic_range * lower
    return _make_quantity(
        variable,
        initial=initial,
        lower=lower,
        upper=upper,
        prior=prior,
        scale="log" if logarithmic else "linear",
    )


def _range(variable: Variable, entry: Mapping[str, Any], where: str) -> tuple[float, float]:
    """Return the stated bounds, or the FMU's where none is stated; refuse bounds beyond the FMU's."""
    least = -math.inf if variable.lower is None else variable.lower
    most = math.inf if variable.upper is None else variable.upper
    lower, upper = float(entry.get("lower", least)), float(entry.get("upper", most))
    if lower < least or upper > most:
        expected = f"bounds in [{least:g}, {most:g}], as the FMU says"
        raise InputError(where, expected=expected, got=f"[{lower:g}, {upper:g}]")
    if not lower < upper:
        raise InputError(where, expected="lower < upper", got=f"lower {lower:g}, upper {upper:g}")
    return lower, upper


def _make_quantity(variable: Variable, **numbers: Any) -> Quantity:
    """Return a variable's quantity with its numbers."""
    # In equations t is the time.
    id = "parameter t" if variable.name == "t" else variable.name
    unit = variable.unit or "1"
    return Quantity(id=id, structured=variable.name, unit=unit, description=variable.description, **numbers)
