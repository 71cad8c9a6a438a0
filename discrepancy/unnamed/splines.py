"""A torque as a smooth function of one variable: cubic B-splines on equidistant knots, as an effect and as numbers.

Weights of the splines that make up for a polynomial which the base holds already (a spring's stiffness and place,
viscous friction, a gain) are left out: which part of it the base holds and which the splines would be open else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy as sp

from haptid.discrepancy.detect.localise import AXES
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect, parameter, reference
from haptid.model.effects.effect import q as position
from haptid.model.effects.effect import v as velocity
from haptid.model.effects.effect import w as torque
from haptid.model.equations.equations import TIME
from haptid.model.equations.quantity import Quantity

INTERVALS, POINTS = 7, 15
"""Stretches of the variable, each with a cubic of its own, and values at which the torque is told."""
PLACES = range(-1, INTERVALS + 2)
"""Centres of the B-splines, in stretches from the first one."""
BINOMIAL = (1, -4, 6, -4, 1)
"""Weights of the truncated powers (t + 2 − j)₊³/6 in a cubic B-spline about t = 0."""
SYMBOLS = {"position_rad": position, "velocity_rad_s": velocity, "torque_Nm": torque, "time_s": TIME}
"""What a missing torque may live in."""
HELD = {"position_rad": 2, "velocity_rad_s": 2, "torque_Nm": 2, "time_s": 1}
"""Powers of each variable that the base holds: a spring's stiffness and place, viscous friction, the gain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Functions of one variable between ``first`` and ``last``, constant beyond."""

    variable: str
    first: float
    last: float

    @property
    def variables(self) -> tuple[str, ...]:
        """The variable."""
        return (self.variable,)

    @property
    def knots(self) -> tuple[Array, ...]:
        """Values at which the torque is told, (POINTS,)."""
        return (np.linspace(self.first, self.last, POINTS),)

    @property
    def design(self) -> Array:
        """Torque at the knots, less what the base holds, by the weights: shape (POINTS, n_weights)."""
        splines = basis(np.linspace(0.0, INTERVALS, POINTS))
        return np.asarray(without_polynomial(self.knots[0], HELD[self.variable]) @ splines @ mixtures(self.variable))

    def effect(self, scale: float) -> Effect:
        """Return the effect Σ aₖ·sₖ(x); |aₖ| is bounded by ten times ``scale`` [N m].

        The ends of the range are fixed parameters: one kernel serves every range.
        """
        ends = [
            fix_shape_parameter(name, self.variable, value)
            for name, value in (("first", self.first), ("last", self.last))
        ]
        first, last = (end.symbol for end in ends)
        t = (sp.Min(sp.Max(SYMBOLS[self.variable], first), last) - first) * INTERVALS / (last - first)
        powers = [[w * sp.Max(t - place + 2 - j, 0) ** 3 / 6 for j, w in enumerate(BINOMIAL)] for place in PLACES]
        splines = sp.Matrix([sp.Add(*row) for row in powers])
        free = mixtures(self.variable)
        quantities = tuple(
            parameter(f"shape{k}", "N m", f"weight {k} of the missing torque", 0.0, -10 * scale, 10 * scale)
            for k in range(free.shape[1])
        )
        missing = sp.Add(*(q.symbol * (splines.T @ column)[0] for q, column in zip(quantities, free.T, strict=True)))
        name = self.variable.partition("_")[0]
        return Effect(
            id=f"shape_over_{name}", title=f"missing torque over {name}", formula="Σ aₖ·sₖ(x)", lives_in=name,
            side="torque", parameters=(*quantities, *ends), amplitudes=len(quantities), torque=missing,
        )  # fmt: skip


def fix_shape_parameter(name: str, variable: str, value: float) -> Quantity:
    """Return a fixed parameter ``shape_<name>``: a number that says where on its variable a missing torque lives."""
    _, unit = AXES[variable]
    row = reference(f"shape_{name}", unit, f"{name} of the missing torque's variable")
    return row.but(initial=value, lower=-np.inf, upper=np.inf)


def mixtures(variable: str) -> Array:
    """Return weights of the B-splines, column by column, that together hold no polynomial that the base holds.

    Weights of equal size make a constant, equidistant ones a straight line.
    """
    held = np.vander(np.array(PLACES, dtype=float), HELD[variable])
    return np.linalg.qr(held, mode="complete")[0][:, HELD[variable] :]


def basis(t: Array) -> Array:
    """Return all B-splines (n, len(PLACES)) at t (n,) in [0, INTERVALS]."""
    powers = [w * np.maximum(t[:, None] - np.array(PLACES) + 2 - j, 0.0) ** 3 for j, w in enumerate(BINOMIAL)]
    return np.asarray(np.sum(powers, axis=0) / 6)


def without_polynomial(knots: Array, terms: int) -> Array:
    """Return the projector (n, n) that takes the first ``terms`` powers off a function at the knots."""
    Q = np.linalg.qr(np.vander((knots - knots.mean()) / np.ptp(knots), terms))[0]
    return np.asarray(np.eye(knots.size) - Q @ Q.T)
