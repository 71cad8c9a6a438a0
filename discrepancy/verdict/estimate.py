"""Hold estimates with standard errors and 95 % intervals, which need not be symmetric about the value."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy.stats import chi2, norm

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.equations.quantity import Quantity

LARGEST_EXPONENT = 300.0
"""Exponent of an interval's ends on a logarithmic scale beyond which they would not stay finite numbers."""


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
    def of_parameter(cls, quantity: Quantity, value: float, std: float) -> Self:
        """Return the estimate of a parameter, whose interval keeps to the sign that physics gives it.

        Parameters
        ----------
        quantity
            The parameter.
        value
            Estimate in the unit of the parameter.
        std
            Standard error in that unit.

        Returns
        -------
        Estimate
            On a logarithmic scale the interval value·exp(±1.96·std/value); otherwise value ± 1.96·std, which ends at
            0 where the parameter cannot be negative.
        """
        made = cls.normal(value, std, quantity.unit)
        low, high = made.interval
        if quantity.scale == "log":
            # A std of several times the value says that the order of magnitude is open; e^700 is no number any more.
            half = min((high - value) / value, LARGEST_EXPONENT)
            return replace(made, interval=(float(value * np.exp(-half)), float(value * np.exp(half))))
        return replace(made, interval=(max(low, 0.0) if quantity.lower == 0.0 else low, high))

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
        """Convert to an entry of a named effect's ``parameters`` in the finding's JSON.

        Returns
        -------
        dict
            ``value``, ``std``, ``unit``, and ``interval`` as a list of both ends.
        """
        return {"value": self.value, "std": self.std, "unit": self.unit, "interval": list(self.interval)}
