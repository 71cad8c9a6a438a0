"""Represent a torque over one variable by cubic B-splines on equidistant knots: a range in, an `Effect` out.

The nominal model holds some polynomials of each variable already (stiffness and place of a spring, viscous friction, a
gain). Combinations of splines that make up such a polynomial are left out, since otherwise the division between
nominal model and splines would not be identifiable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sympy as sp

from haptid.discrepancy.detect.localise import AXES
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect, parameter, reference
from haptid.model.effects.effect import q as position
from haptid.model.effects.effect import v as velocity
from haptid.model.effects.effect import w as torque
from haptid.model.equations.equations import TIME
from haptid.model.equations.quantity import Quantity

PLACES = range(-1, THRESHOLDS.unnamed.spline_intervals + 2)
"""Centres of the B-splines, in stretches from the first knot."""
WEIGHTS_OF_POWERS = (1, -4, 6, -4, 1)
"""Weights of the truncated powers (t + 2 − j)₊³/6 in a cubic B-spline about t = 0."""
SYMBOLS = {"position_rad": position, "velocity_rad_s": velocity, "torque_Nm": torque, "time_s": TIME}
"""Variables over which a missing torque is fitted, with their symbols."""
HELD = {"position_rad": 2, "velocity_rad_s": 2, "torque_Nm": 2, "time_s": 1}
"""Number of powers of each variable, from the constant on, that the nominal model holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Spline functions of one variable between two ends, constant beyond.

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
    def variables(self) -> tuple[str, ...]:
        """The variable, as a tuple."""
        return (self.variable,)

    @property
    def knots(self) -> tuple[Array, ...]:
        """Values of the variable at which the torque is returned, shape (n_knots,)."""
        return (np.linspace(self.first, self.last, THRESHOLDS.unnamed.curve_points),)

    @property
    def design(self) -> Array:
        """Matrix from weights to torque at the knots without the nominal model's part, shape (n_knots, n_weights)."""
        splines = basis(np.linspace(0.0, THRESHOLDS.unnamed.spline_intervals, THRESHOLDS.unnamed.curve_points))
        return np.asarray(without_polynomial(self.knots[0], HELD[self.variable]) @ splines @ mixtures(self.variable))

    def effect(self, scale: float) -> Effect:
        """Return the effect Σ aₖ·sₖ(x).

        The ends of the range are fixed parameters, so that one compiled kernel serves every range.

        Parameters
        ----------
        scale
            Typical torque [N m]; every |aₖ| is bounded by ten times this torque.

        Returns
        -------
        Effect
            Effect on the torque whose amplitudes are the weights aₖ.
        """
        ends = [
            fix_shape_parameter(name, self.variable, value)
            for name, value in (("first", self.first), ("last", self.last))
        ]
        first, last = (end.symbol for end in ends)
        held = sp.Min(sp.Max(SYMBOLS[self.variable], first), last)
        t = (held - first) * THRESHOLDS.unnamed.spline_intervals / (last - first)
        powers = [
            [w * sp.Max(t - place + 2 - j, 0) ** 3 / 6 for j, w in enumerate(WEIGHTS_OF_POWERS)] for place in PLACES
        ]
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
    """Return a fixed parameter ``shape_<name>`` that places a missing torque on its variable.

    Parameters
    ----------
    name
        What the number is, for example ``first``.
    variable
        Key of `SYMBOLS`, which gives the unit.
    value
        Value in that unit.

    Returns
    -------
    Quantity
        Fixed parameter without bounds.
    """
    _, unit = AXES[variable]
    row = reference(f"shape_{name}", unit, f"{name} of the missing torque's variable")
    return row.but(initial=value, lower=-np.inf, upper=np.inf)


def mixtures(variable: str) -> Array:
    """Return the combinations of B-splines that hold no polynomial of the nominal model.

    Parameters
    ----------
    variable
        Key of `SYMBOLS`.

    Returns
    -------
    ndarray
        Orthonormal weights, one combination per column, shape (len(PLACES), n_weights).
    """
    # Equal weights make a constant, and weights linear in the place a straight line. So the orthogonal complement of
    # such weights holds no polynomial of that many powers.
    held = np.vander(np.array(PLACES, dtype=float), HELD[variable])
    return np.linalg.qr(held, mode="complete")[0][:, HELD[variable] :]


def basis(t: Array) -> Array:
    """Return all B-splines at ``t``.

    Parameters
    ----------
    t
        Values in stretches from the first knot, in [0, `spline_intervals`], shape (n,).

    Returns
    -------
    ndarray
        Values of the splines, shape (n, len(PLACES)).
    """
    powers = [w * np.maximum(t[:, None] - np.array(PLACES) + 2 - j, 0.0) ** 3 for j, w in enumerate(WEIGHTS_OF_POWERS)]
    return np.asarray(np.sum(powers, axis=0) / 6)


def without_polynomial(knots: Array, terms: int) -> Array:
    """Return the projector that removes a polynomial from a function at the knots.

    Parameters
    ----------
    knots
        Values of the variable, shape (n,).
    terms
        Number of powers that are removed, from the constant on.

    Returns
    -------
    ndarray
        Projector, shape (n, n).
    """
    Q = np.linalg.qr(np.vander((knots - knots.mean()) / np.ptp(knots), terms))[0]
    return np.asarray(np.eye(knots.size) - Q @ Q.T)
