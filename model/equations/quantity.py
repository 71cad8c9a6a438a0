"""A physical quantity with its unit, range and prior: the row of every parameter table.

Readers of devices, effects and friction laws make a `Quantity`; fits, samplers, FMUs and reports read it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import sympy as sp


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Normal prior N(mean, std²).

    Parameters
    ----------
    mean, std
        Mean and standard deviation, in the unit of the quantity.
    source
        Who put it in: the campaign or the device (``stated``), tests before this one (``earlier``), or haptid itself,
        to hold what runs leave open (``restraint``).
    """

    mean: float
    std: float
    source: Literal["stated", "earlier", "restraint"] = "stated"

    def __post_init__(self) -> None:
        """Check that both numbers are finite and the width is positive.

        Raises
        ------
        ValueError
            Where one of them is not.
        """
        if not (math.isfinite(self.mean) and math.isfinite(self.std) and self.std > 0):
            msg = f"a normal prior needs a finite mean and a positive std, got {self.mean}, {self.std}"
            raise ValueError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """A parameter: identity, unit, first guess, bounds and prior.

    Parameters
    ----------
    id
        Name in files and reports (``sigma0``); `symbol` is the SymPy symbol of the same name.
    unit
        SI unit as in ``N m s/rad``; ``1`` where there is none.
    description
        Words for a reader.
    initial, lower, upper
        First guess and bounds, in ``unit``.
    prior
        Normal prior, or None for a flat one between the bounds.
    fixed
        Known and not fitted.
    scale
        ``log`` for quantities that are positive and known to an order of magnitude, else ``linear``.
    structured
        FMI structured name below the joint (``friction.sigma0``); the id where empty.
    """

    id: str
    unit: str
    description: str
    initial: float
    lower: float = -math.inf
    upper: float = math.inf
    prior: Normal | None = None
    fixed: bool = False
    scale: str = "linear"
    structured: str = ""

    def __post_init__(self) -> None:
        """Check that the first guess lies within the bounds and the scale suits them.

        Raises
        ------
        ValueError
            Where the first guess lies outside the bounds, the scale is unknown, or a fitted parameter on a logarithmic
            scale may be zero or negative.
        """
        if not self.lower <= self.initial <= self.upper:
            msg = f"{self.id}: initial {self.initial} lies outside [{self.lower}, {self.upper}]"
            raise ValueError(msg)
        if self.scale not in ("log", "linear") or (self.scale == "log" and self.lower <= 0 and not self.fixed):
            msg = f"{self.id}: scale {self.scale!r} with lower bound {self.lower}"
            raise ValueError(msg)

    @property
    def symbol(self) -> sp.Symbol:
        """The SymPy symbol of this quantity."""
        return sp.Symbol(self.id, real=True)

    def but(self, **changes: Any) -> Quantity:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Quantity
            The copy, checked as any other.
        """
        return replace(self, **changes)
