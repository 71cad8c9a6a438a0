"""Variables of a foreign FMU: model description in, `Variable` by name out, and typed access to an instance's values.

All values are read and written as real numbers, whatever the variable's type: 0 and 1 for a Boolean.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.measurement.values.run import Array

REAL = ("Real", "Float32", "Float64")
"""Types of FMI 2.0 and 3.0 whose values are real numbers."""
_WITHOUT_NUMBER = ("String", "Binary", "Clock")


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A variable as the model description states it.

    Parameters
    ----------
    name, unit, description
        Name, unit (empty where there is none), and words for a reader.
    type, causality, variability
        As the FMI standard names them: ``Real``, ``parameter``, ``fixed``.
    initial
        ``exact``, ``approx`` or ``calculated``; empty where the standard gives none.
    scalar
        Whether it is a single number.
    start, lower, upper
        Start value, least and largest value, in ``unit``; None where they are not stated.
    """

    name: str
    unit: str
    description: str
    type: str
    causality: str
    variability: str
    initial: str
    scalar: bool
    start: float | None
    lower: float | None
    upper: float | None

    @property
    def is_settable(self) -> bool:
        """Whether its start value can be set before initialisation (FMI 2.0.4, section 2.2.7; FMI 3.0, 2.4.7.5)."""
        if self.variability == "constant" or self.causality == "independent":
            return False
        if self.causality in ("input", "parameter", "structuralParameter"):
            return self.initial != "calculated"
        return self.initial in ("exact", "approx")

    @property
    def kind(self) -> str:
        """Causality, variability and, where it is calculated, that word: for errors."""
        calculated = " calculated" if self.initial == "calculated" else ""
        return f"a {self.variability}{calculated} {self.causality} of type {self.type}"


def variables_of(description: Any) -> dict[str, Variable]:
    """Return the variables of a model description.

    Parameters
    ----------
    description
        Model description, as fmpy read it.

    Returns
    -------
    dict
        `Variable` by name.
    """
    return {v.name: _variable(v) for v in description.modelVariables}


def _variable(v: Any) -> Variable:
    declared = v.declaredType
    return Variable(
        name=v.name,
        unit=v.unit or (declared.unit if declared is not None else None) or "",
        description=v.description or "",
        type=v.type,
        causality=v.causality or "local",
        variability=v.variability or "continuous",
        initial=v.initial or "",
        scalar=v.type not in _WITHOUT_NUMBER and not v.dimensions,
        start=_number(v.start),
        lower=_number(v.min if v.min is not None or declared is None else declared.min),
        upper=_number(v.max if v.max is not None or declared is None else declared.max),
    )


def _number(text: Any) -> float | None:
    if text in ("true", "false"):
        return float(text == "true")
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    return value if np.isfinite(value) else None


def writer(fmu: Any, description: Any, names: Sequence[str]) -> Callable[[Array], None]:
    """Return the function that sets variables of an instance.

    Parameters
    ----------
    fmu
        Instance, as fmpy made it.
    description
        Its model description.
    names
        Variables in the order of the values.

    Returns
    -------
    callable
        Takes values, shape (n_names,); they are rounded where the type holds whole numbers.
    """
    groups = _by_type(description, names)

    def write(values: Array) -> None:
        for kind, (places, references) in groups.items():
            own = values[places]
            if kind == "Boolean":
                numbers: list[Any] = [bool(value) for value in own]
            elif kind in REAL:
                numbers = own.tolist()
            else:
                numbers = [round(value) for value in own]
            getattr(fmu, f"set{kind}")(references, numbers)

    return write


def reader(fmu: Any, description: Any, names: Sequence[str]) -> Callable[[], Array]:
    """Return the function that reads variables of an instance.

    Parameters
    ----------
    fmu
        Instance, as fmpy made it.
    description
        Its model description.
    names
        Variables in the order of the values.

    Returns
    -------
    callable
        Takes nothing and returns the values, shape (n_names,).
    """
    groups = _by_type(description, names)

    def read() -> Array:
        values = np.empty(len(names))
        for kind, (places, references) in groups.items():
            values[places] = getattr(fmu, f"get{kind}")(references)
        return values

    return read


def _by_type(description: Any, names: Sequence[str]) -> Mapping[str, tuple[list[int], list[int]]]:
    """Group names by the type of FMI's functions: places among the names, and value references."""
    of = {v.name: v for v in description.modelVariables}
    enumeration = "Integer" if description.fmiVersion == "2.0" else "Int64"
    groups: dict[str, tuple[list[int], list[int]]] = {}
    for place, name in enumerate(names):
        kind = enumeration if of[name].type == "Enumeration" else of[name].type
        places, references = groups.setdefault(kind, ([], []))
        places.append(place)
        references.append(of[name].valueReference)
    return groups
