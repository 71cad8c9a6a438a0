"""Units of the FMI description: a unit text in, `Unit` out with SI exponents, factor and display unit."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Base units of FMI 2.0, in the schema's order."""

_DERIVED: dict[str, tuple[float, dict[str, int]]] = {
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "J": (1.0, {"kg": 1, "m": 2, "s": -2}),
    "W": (1.0, {"kg": 1, "m": 2, "s": -3}),
    "V": (1.0, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "Hz": (1.0, {"s": -1}),
    "g": (1e-3, {"kg": 1}),
    "mm": (1e-3, {"m": 1}),
    "ms": (1e-3, {"s": 1}),
    "deg": (math.pi / 180, {"rad": 1}),
}

_DISPLAY = {
    "rad": ("deg", 180 / math.pi),
    "rad/s": ("deg/s", 180 / math.pi),
    "rad/s^2": ("deg/s^2", 180 / math.pi),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "s": ("ms", 1e3),
    "kg": ("g", 1e3),
    "N m": ("mN m", 1e3),
    "N m/rad": ("N m/deg", math.pi / 180),
    "kg m^2": ("g m^2", 1e3),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """Hold a unit in terms of the base units.

    Parameters
    ----------
    name
        Text of the unit, as ``N m/rad``.
    factor
        Value in SI per value in this unit.
    exponents
        Base unit of `BASE` and its exponent, in the order of `BASE`, without zeros.
    """

    name: str
    factor: float
    exponents: tuple[tuple[str, int], ...]

    @property
    def display(self) -> tuple[str, float] | None:
        """Name and factor of the display unit: value in display unit = factor · value in this unit."""
        return _DISPLAY.get(self.name)


def _tokens(text: str) -> list[tuple[str, str]]:
    """Return symbols and exponents of a product, as ``N m s^2`` or ``N.m.s2``; an empty exponent is 1."""
    return re.findall(r"([^\s.()^\d-]+|1)\^?(-?\d+)?", text)


def modelica_unit(text: str) -> str:
    """Return a unit in the syntax of Modelica, which model descriptions use: no blanks, exponents without a sign.

    Parameters
    ----------
    text
        Unit, as ``N m s/rad``; all symbols behind the slash divide.

    Returns
    -------
    str
        Unit with dots for products.

    Examples
    --------
    >>> modelica_unit("N m s/rad"), modelica_unit("kg m^2"), modelica_unit("N m/rad s"), modelica_unit("1")
    ('N.m.s/rad', 'kg.m2', 'N.m/(rad.s)', '1')
    """
    above, _, below = text.partition("/")
    products = [[f"{symbol}{power}" for symbol, power in _tokens(part)] for part in (above, below)]
    top, bottom = (".".join(product) for product in products)
    if not bottom:
        return top
    return f"{top}/({bottom})" if len(products[1]) > 1 else f"{top}/{bottom}"


def parse_unit(text: str) -> Unit:
    """Parse a unit, as ``N m s/rad``: factors are separated by spaces, all factors behind the slash divide.

    Parameters
    ----------
    text
        Factors with optional exponents (``s^2``) and at most one slash; ``1`` is no unit. Modelica's syntax
        (``N.m.s/rad``, ``s2``) is understood as well.

    Returns
    -------
    Unit
        In SI base units and rad.

    Raises
    ------
    ValueError
        Where a factor is no known unit, or its exponent no whole number.

    Examples
    --------
    >>> parse_unit("N m/rad").exponents
    (('kg', 1), ('m', 2), ('s', -2), ('rad', -1))
    """
    total, factor = dict.fromkeys(BASE, 0), 1.0
    above, _, below = text.partition("/")
    for part, sign in ((above, 1), (below, -1)):
        for symbol, power in _tokens(part):
            if symbol == "1":
                continue
            scale, exponents = _DERIVED.get(symbol, (1.0, {symbol: 1}))
            n = sign * int(power or 1)
            factor *= scale**n
            for base, exponent in exponents.items():
                if base not in total:
                    msg = (
                        f"unit {text!r}: {base!r} is neither one of {', '.join(BASE)} nor one of {', '.join(_DERIVED)}"
                    )
                    raise ValueError(msg)
                total[base] += n * exponent
    return Unit(name=text, factor=factor, exponents=tuple((b, n) for b, n in total.items() if n))
