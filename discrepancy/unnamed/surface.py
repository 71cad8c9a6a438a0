"""Represent a torque over two variables by products of Chebyshev polynomials: ranges in, an `Effect` out.

Each polynomial is one of s = (x − c)/√((x − c)² + b²), which is bounded however far a variable goes. Over speed, b is a
tenth of the largest speed, so that the polynomials can follow friction, which turns with the direction. Constants and
the lowest polynomials of either variable alone are held by the nominal model (a spring, friction, the gain) and left
out.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import sympy as sp
from numpy.polynomial.chebyshev import chebvander

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.unnamed.splines import HELD, SYMBOLS, fix_shape_parameter
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect, parameter
from haptid.model.equations.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One variable of a surface, between two ends.

    Parameters
    ----------
    variable
        Key of `SYMBOLS`.
    first, last
        Ends of the range in the variable's unit.
    """

    variable: str
    first: float
    last: float

    @property
    def centre(self) -> float:
        """Centre c in the variable's unit: the middle of the range, but 0 over speed."""
        return 0.0 if self.variable == "velocity_rad_s" else (self.first + self.last) / 2

    @property
    def width(self) -> float:
        """Width b in the variable's unit: half of the range, but a share of the largest speed over speed."""
        if self.variable == "velocity_rad_s":
            return THRESHOLDS.unnamed.width_over_largest_speed * max(abs(self.first), abs(self.last))
        return (self.last - self.first) / 2

    @property
    def knots(self) -> Array:
        """Values of the variable that are equidistant in s, shape (n_knots,)."""
        low, high = self.coordinate(np.array([self.first, self.last]))
        s = np.linspace(low, high, THRESHOLDS.unnamed.surface_points_per_variable)
        return np.asarray(self.centre + self.width * s / np.sqrt(1.0 - s**2))

    def coordinate(self, x: Array) -> Array:
        """Return s(x), in (−1, 1), in the shape of x.

        Parameters
        ----------
        x
            Values in the variable's unit, any shape.

        Returns
        -------
        ndarray, shape of ``x``
            s = (x − c)/√((x − c)² + b²) [1].
        """
        return np.asarray((x - self.centre) / np.hypot(x - self.centre, self.width))


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """Functions of two variables: products of Chebyshev polynomials.

    Parameters
    ----------
    axes
        The two variables.
    """

    axes: tuple[Axis, Axis]

    @property
    def variables(self) -> tuple[str, ...]:
        """Both variables."""
        return tuple(axis.variable for axis in self.axes)

    @property
    def knots(self) -> tuple[Array, ...]:
        """Values of each variable at which the torque is returned, shape (n_knots,) each."""
        return tuple(axis.knots for axis in self.axes)

    @property
    def terms(self) -> list[tuple[int, int]]:
        """Orders (i, j) of the products that are fitted, without those that the nominal model holds."""
        one, two = (HELD[variable] for variable in self.variables)
        held = {(i, 0) for i in range(one)} | {(0, j) for j in range(two)}
        orders = range(THRESHOLDS.unnamed.surface_order + 1)
        return [(i, j) for i, j in product(orders, orders) if (i, j) not in held]

    @property
    def design(self) -> Array:
        """Matrix from weights to torque at the knots, shape (n_knots², n_weights); the second variable runs fastest."""
        first, second = (
            chebvander(axis.coordinate(axis.knots), THRESHOLDS.unnamed.surface_order) for axis in self.axes
        )
        return np.column_stack([np.kron(first[:, i], second[:, j]) for i, j in self.terms])

    def effect(self, scale: float) -> Effect:
        """Return the effect Σ aᵢⱼ·Tᵢ(s₁)·Tⱼ(s₂).

        Centres and widths are fixed parameters, so that one compiled kernel serves every range.

        Parameters
        ----------
        scale
            Typical torque [N m]; every |aᵢⱼ| is bounded by ten times this torque.

        Returns
        -------
        Effect
            Effect on the torque whose amplitudes are the weights aᵢⱼ.
        """
        coordinates, ranges = zip(*(_symbolic(axis, k) for k, axis in enumerate(self.axes)), strict=True)
        first, second = (
            [sp.expand(sp.chebyshevt(k, s)) for k in range(THRESHOLDS.unnamed.surface_order + 1)] for s in coordinates
        )
        weights = tuple(
            parameter(f"shape{i}{j}", "N m", f"weight {i}, {j} of the missing torque", 0.0, -10 * scale, 10 * scale)
            for i, j in self.terms
        )
        names = [variable.partition("_")[0] for variable in self.variables]
        return Effect(
            id=f"shape_over_{'_and_'.join(names)}", title=f"missing torque over {' and '.join(names)}",
            formula="Σ aᵢⱼ·Tᵢ(s₁)·Tⱼ(s₂)", lives_in=names[0], side="torque",
            parameters=(*weights, *ranges[0], *ranges[1]), amplitudes=len(weights),
            torque=sp.Add(*(a.symbol * first[i] * second[j] for a, (i, j) in zip(weights, self.terms, strict=True))),
        )  # fmt: skip


def _symbolic(axis: Axis, number: int) -> tuple[sp.Expr, tuple[Quantity, Quantity]]:
    """Return s of one variable as an expression, with its centre and width as fixed parameters."""
    centre = fix_shape_parameter(f"centre{number}", axis.variable, axis.centre)
    width = fix_shape_parameter(f"width{number}", axis.variable, axis.width)
    x = SYMBOLS[axis.variable] - centre.symbol
    return x / sp.sqrt(x**2 + width.symbol**2), (centre, width)
