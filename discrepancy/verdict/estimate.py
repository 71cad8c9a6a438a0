"""Hold estimates with standard errors and 95 % intervals, which need not be symmetric about the value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.stats import chi2, norm

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A parameter's value with its uncertainty.

    Parameters
    ----------
    value
        Estimate in ``unit``.
    std
        Standard error in ``unit``.
    unit
        Unit of the parameter.
    interval
        Ends of the 95 % interval in ``unit``.
    """

    value: float
    std: float
    unit: str
    interval: tuple[float, float]

    @classmethod
    def normal(cls, value: float, std: float, unit: str) -> Self:
        """Return the estimate with the interval of a normal error.

        Parameters
        ----------
        value
            Estimate in ``unit``.
        std
            Standard error in ``unit``.
        unit
            Unit of the parameter.

        Returns
        -------
        Estimate
            Estimate with the interval value ± 1.96·std.
        """
        half = float(norm.ppf(0.5 + THRESHOLDS.fit.interval_coverage / 2)) * std
        return cls(value=value, std=std, unit=unit, interval=(value - half, value + half))

    @classmethod
    def of_deviation(cls, value: float, freedom: float, unit: str) -> Self:
        """Return the estimate of a standard deviation.

        Parameters
        ----------
        value
            Standard deviation s.
        freedom
            Degrees of freedom f.
        unit
            Unit of s.

        Returns
        -------
        Estimate
            Standard error s/√(2f), and interval from s·√(f/χ²_f(0.975)) to s·√(f/χ²_f(0.025)). With few degrees of
            freedom it reaches farther up than down.

        References
        ----------
        Mood, Graybill and Boes 1974, section VIII.3.2.
        """
        half = THRESHOLDS.fit.interval_coverage / 2
        low, high = (float(value * np.sqrt(freedom / chi2.ppf(p, freedom))) for p in (0.5 + half, 0.5 - half))
        return cls(value=value, std=float(value / np.sqrt(2.0 * freedom)), unit=unit, interval=(low, high))

    def as_json(self) -> dict[str, Any]:
        """Return the fields of INTERFACES, and the interval."""
        return {"value": self.value, "std": self.std, "unit": self.unit, "interval": list(self.interval)}
