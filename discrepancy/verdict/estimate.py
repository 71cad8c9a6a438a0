"""An estimate with its standard error and its 95 % interval, which need not lie evenly about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.stats import chi2, norm

LEVEL = 0.95
"""Share of such intervals that are to hold the true value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A parameter's value, its standard error and the ends of its 95 % interval, all in ``unit``."""

    value: float
    std: float
    unit: str
    interval: tuple[float, float]

    @classmethod
    def normal(cls, value: float, std: float, unit: str) -> Self:
        """Return the estimate whose interval is that of a normal error, value ± 1.96 std."""
        half = float(norm.ppf(0.5 + LEVEL / 2)) * std
        return cls(value=value, std=std, unit=unit, interval=(value - half, value + half))

    @classmethod
    def of_deviation(cls, value: float, freedom: float, unit: str) -> Self:
        """Return that of a standard deviation s of f degrees of freedom.

        Its error is s/√(2f) and its interval s·√(f/χ²_f(0.975)) to s·√(f/χ²_f(0.025)) (Mood, Graybill and Boes 1974,
        section VIII.3.2): of few cycles it reaches farther up than down.
        """
        low, high = (float(value * np.sqrt(freedom / chi2.ppf(p, freedom))) for p in (0.5 + LEVEL / 2, 0.5 - LEVEL / 2))
        return cls(value=value, std=float(value / np.sqrt(2.0 * freedom)), unit=unit, interval=(low, high))

    def as_json(self) -> dict[str, Any]:
        """Fields of INTERFACES, and the interval."""
        return {"value": self.value, "std": self.std, "unit": self.unit, "interval": list(self.interval)}
