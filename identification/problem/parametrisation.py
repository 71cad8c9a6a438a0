"""Coordinates of the free parameters: `Equations` in, `Parametrisation` out, for fits, search and sampler.

s = ln p where a parameter moves in its logarithm, s = (p − p₀)/w otherwise. Optimisers and walkers move s, equations
take p. A fit takes the logarithm of quantities of scale ``log`` only, and for the others p₀ the first guess and w the
prior's standard deviation, a quarter of the range, or the size of the first guess, in this order of preference. The
sampler takes the logarithm of every positive quantity, and the others as they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity


def linear_unit(quantity: Quantity) -> float:
    """Choose the unit w of a quantity of linear scale.

    Parameters
    ----------
    quantity
        Quantity with first guess, bounds and perhaps a prior.

    Returns
    -------
    float
        The prior's standard deviation, else a quarter of the range, else the size of the first guess (1 where that is
        0), in the quantity's own unit.
    """
    if quantity.prior is not None:
        return quantity.prior.std
    span = quantity.upper - quantity.lower
    size = abs(quantity.initial) or 1.0
    return span / 4.0 if math.isfinite(span) and span <= THRESHOLDS.largest_range_over_guess * size else size


def positive(quantity: Quantity) -> bool:
    """Say whether a quantity is positive over its whole range, so that it can move in its logarithm.

    Parameters
    ----------
    quantity
        Parameter with its bounds and first guess.

    Returns
    -------
    bool
        True for logarithmic scale, and for a lower bound of 0 or more with a positive first guess.
    """
    return quantity.scale == "log" or (quantity.lower >= 0 and quantity.initial > 0)


PROJECTIONS = 60
"""Most alternating projections onto bounds and orderings: each halves what is left beside a bound, down to rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parametrisation:
    """Map between the free parameters p of some equations and their coordinates s.

    Parameters
    ----------
    equations
        Equations that the parameters belong to.
    free
        Indices of the parameters that move, ascending, shape (n_free,).
    log
        Whether a free parameter moves in its logarithm, shape (n_free,).
    centre, unit
        p₀ and w of the other parameters (0 and 1 of the logarithms), shape (n_free,).
    lower, upper
        Bounds of p, shape (n_free,); infinite where a parameter has none, above 0 where it moves in its logarithm.
    """

    equations: Equations
    free: tuple[int, ...]
    log: tuple[bool, ...]
    centre: Array
    unit: Array
    lower: Array
    upper: Array

    @classmethod
    def of(cls, equations: Equations, *, every_positive_in_log: bool = False) -> Parametrisation:
        """Give every parameter that is not fixed a coordinate.

        Parameters
        ----------
        equations
            Equations with bounds, priors and first guesses.
        every_positive_in_log
            Whether every positive quantity moves in its logarithm and the others as they are (p₀ = 0, w = 1), as the
            sampler needs it; else only quantities of scale ``log`` do, and the others are centred and scaled.

        Returns
        -------
        Parametrisation
        """
        free = tuple(i for i, q in enumerate(equations.parameters) if not q.fixed)
        quantities = [equations.parameters[i] for i in free]
        log = tuple(positive(q) if every_positive_in_log else q.scale == "log" for q in quantities)
        plain = np.array(log, dtype=bool) | every_positive_in_log
        floor = [q.lower if q.lower > 0 else THRESHOLDS.smallest_bound_over_guess * q.initial for q in quantities]
        return cls(
            equations=equations,
            free=free,
            log=log,
            centre=np.where(plain, 0.0, [q.initial for q in quantities]),
            unit=np.where(plain, 1.0, [linear_unit(q) for q in quantities]),
            lower=np.where(log, floor, [q.lower for q in quantities]),
            upper=np.array([q.upper for q in quantities]),
        )

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The free parameters."""
        return tuple(self.equations.parameters[i] for i in self.free)

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the free parameters."""
        return tuple(q.id for q in self.quantities)

    @property
    def initial(self) -> Array:
        """All first guesses, shape (n_p,)."""
        return np.array([q.initial for q in self.equations.parameters])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of s, shape (n_free,) each; infinite where a parameter has none."""
        return self.coordinates(self.lower), self.coordinates(self.upper)

    def values(self, s: Array) -> Array:
        """Convert coordinates into free parameters.

        Parameters
        ----------
        s
            Coordinates, shape (…, n_free).

        Returns
        -------
        ndarray, shape (…, n_free)
            p in physical units, clipped to the bounds.
        """
        # exp overflows far outside the bounds, where the clipped value stands.
        with np.errstate(over="ignore"):
            p = np.where(self.log, np.exp(s), self.centre + self.unit * s)
        # exp(ln p) may miss a bound by rounding: no parameter leaves its bounds.
        return np.clip(p, self.lower, self.upper)

    def coordinates(self, p: Array) -> Array:
        """Convert free parameters into coordinates, the inverse of `values`.

        Parameters
        ----------
        p
            Free parameters in their units, shape (…, n_free).

        Returns
        -------
        ndarray, shape (…, n_free)
            s; −∞ for a logarithm of 0.
        """
        # Both branches of `where` are evaluated: a linear parameter of 0 or below would warn in the logarithm.
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(p), (p - self.centre) / self.unit)

    def physical(self, s: Array) -> Array:
        """Convert coordinates into full parameter sets.

        Parameters
        ----------
        s
            Coordinates, shape (…, n_free).

        Returns
        -------
        ndarray, shape (…, n_p)
            θ in physical units, within the bounds; the fixed parameters keep their first guesses.
        """
        theta = np.tile(self.initial, (*s.shape[:-1], 1))
        theta[..., list(self.free)] = self.values(s)
        return theta

    def to_coordinates(self, theta: Array) -> Array:
        """Convert full parameter sets into coordinates.

        Parameters
        ----------
        theta
            All parameters in their units, shape (…, n_p).

        Returns
        -------
        ndarray, shape (…, n_free)
            s; −∞ for a logarithm of 0.
        """
        return self.coordinates(np.asarray(theta, dtype=np.float64)[..., list(self.free)])

    def slope(self, theta: Array) -> Array:
        """Differentiate the free parameters by their coordinates.

        Parameters
        ----------
        theta
            All parameters in their units, shape (…, n_p).

        Returns
        -------
        ndarray, shape (…, n_free)
            dp/ds: p for a logarithm, w otherwise.
        """
        return np.where(self.log, theta[..., list(self.free)], self.unit)

    def log_slope(self, s: Array) -> Array:
        """Return ln(dp/ds); its sum is the log-volume of the map.

        Parameters
        ----------
        s
            Coordinates, shape (…, n_free).

        Returns
        -------
        ndarray, shape (…, n_free)
            s of a logarithmic coordinate, the logarithm of its unit of a linear one.
        """
        return np.where(self.log, s, np.log(self.unit))

    def meets_orderings(self, theta: Array) -> NDArray[np.bool_]:
        """Say which parameter sets meet all orderings.

        Parameters
        ----------
        theta
            All parameters in their units, shape (…, n_p).

        Returns
        -------
        ndarray of bool, shape (…,)
            True where a ≥ b for every pair (a, b) of ``equations.orderings``.
        """
        place = {q.id: i for i, q in enumerate(self.equations.parameters)}
        held = np.ones(theta.shape[:-1], dtype=bool)
        for above, below in self.equations.orderings:
            held &= theta[..., place[above]] >= theta[..., place[below]]
        return held

    def put_in_order(self, s: Array, margin: float = 0.0) -> Array:
        """Move coordinates to where they meet bounds and orderings, by alternating projections.

        Parameters
        ----------
        s
            Coordinates, shape (n_free,).
        margin
            By how much more than 0 each ordering's difference of coordinates is to be.

        Returns
        -------
        ndarray, shape (n_free,)
            Coordinates within the bounds; an ordering that ends at a bound is met up to rounding.
        """
        moved = np.clip(s, *self.bounds)
        for _ in range(PROJECTIONS):
            before = moved
            for row, limit in zip(*self.orderings(), strict=True):
                short = max(limit + margin - row @ moved, 0.0)
                moved = moved + row * short / (row @ row)
            moved = np.clip(moved, *self.bounds)
            if np.array_equal(moved, before):
                break
        return moved

    def orderings(self) -> tuple[Array, Array]:
        """Write the orderings of pairs of parameters as linear inequalities A·s ≥ b.

        Returns
        -------
        A : ndarray, shape (n_orderings, n_free)
            Coefficients; orderings between fixed parameters are left out.
        b : ndarray, shape (n_orderings,)
            Limits.

        Notes
        -----
        Two parameters of linear scale keep p_a ≥ p_b as it stands, two logarithms keep ln p_a ≥ ln p_b.
        """
        rows, limits = [], []
        for pair in self.equations.orderings:
            row, limit = np.zeros(len(self.free)), 0.0
            moving = [self.ids.index(id) for id in pair if id in self.ids]
            for id, sign in zip(pair, (1.0, -1.0), strict=True):
                if id in self.ids:
                    k = self.ids.index(id)
                    row[k] = sign * self.unit[k]
                    limit -= sign * self.centre[k]
                else:
                    # A fixed parameter is a constant: it moves to the right-hand side, in the coordinate of the other.
                    value = self.equations.parameter(id).initial
                    limit -= sign * (math.log(value) if any(self.log[k] for k in moving) else value)
            if moving:
                rows.append(row)
                limits.append(limit)
        return np.array(rows).reshape(len(limits), len(self.free)), np.array(limits)

    def constraints(self) -> tuple[Array, Array]:
        """Write finite bounds and orderings as linear inequalities A·s ≥ b.

        Returns
        -------
        A : ndarray, shape (n_c, n_free)
            Coefficients.
        b : ndarray, shape (n_c,)
            Limits: those of lower bounds, then of upper bounds, then of orderings.
        """
        lower, upper = self.bounds
        eye = np.eye(len(self.free))
        order, limit = self.orderings()
        keep_lower, keep_upper = np.isfinite(lower), np.isfinite(upper)
        A = np.concatenate([eye[keep_lower], -eye[keep_upper], order])
        return A, np.concatenate([lower[keep_lower], -upper[keep_upper], limit])
