"""Scaled parameters: `Equations` in, `Scaling` out, which converts between physical and scaled parameters.

s = ln p for a quantity of scale ``log``, s = (p − p₀)/w otherwise, with p₀ the first guess and w the prior's standard
deviation, a quarter of the range, or the size of the first guess, in this order of preference. Optimisers move s,
equations take p.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity

WIDEST = 1e6
"""Width of a linear range, over the first guess, above which the range is not used as the size of the quantity."""


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
    return span / 4.0 if math.isfinite(span) and span <= WIDEST * size else size


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaling:
    """The free parameters of some equations in scaled form.

    Parameters
    ----------
    equations
        Equations that the parameters belong to.
    free
        Indices of the parameters that are fitted, ascending, shape (n_free,).
    log
        Whether a free parameter is scaled by its logarithm, shape (n_free,).
    centre, unit
        p₀ and w of the parameters of linear scale (0 and 1 of the logarithms), shape (n_free,).
    """

    equations: Equations
    free: tuple[int, ...]
    log: tuple[bool, ...]
    centre: Array
    unit: Array

    @classmethod
    def of(cls, equations: Equations) -> Scaling:
        """Scale every parameter that is not fixed.

        Parameters
        ----------
        equations
            Equations with bounds, priors and first guesses.

        Returns
        -------
        Scaling
        """
        free = tuple(i for i, q in enumerate(equations.parameters) if not q.fixed)
        chosen = [equations.parameters[i] for i in free]
        return cls(
            equations=equations,
            free=free,
            log=tuple(q.scale == "log" for q in chosen),
            centre=np.array([0.0 if q.scale == "log" else q.initial for q in chosen]),
            unit=np.array([1.0 if q.scale == "log" else linear_unit(q) for q in chosen]),
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

    def scaled(self, theta: Array) -> Array:
        """Convert physical into scaled parameters.

        Parameters
        ----------
        theta
            All parameters in their units, shape (n_p,).

        Returns
        -------
        ndarray, shape (n_free,)
            s; −∞ for a logarithm of 0.
        """
        p = np.asarray(theta, dtype=np.float64)[list(self.free)]
        # Both branches of `where` are evaluated: a linear parameter of 0 or below would warn in the logarithm.
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(p), (p - self.centre) / self.unit)

    def physical(self, s: Array) -> Array:
        """Convert scaled into physical parameters.

        Parameters
        ----------
        s
            Scaled parameters, shape (n_free,).

        Returns
        -------
        ndarray, shape (n_p,)
            θ in physical units, clipped to the bounds; the fixed parameters keep their first guesses.
        """
        theta = self.initial
        with np.errstate(over="ignore"):
            moved = np.where(self.log, np.exp(s), self.centre + self.unit * s)
        lower, upper = np.array([(q.lower, q.upper) for q in self.quantities]).reshape(-1, 2).T
        # exp(ln p) may miss a bound by rounding: no parameter leaves its bounds.
        theta[list(self.free)] = np.clip(moved, lower, upper)
        return theta

    def slope(self, theta: Array) -> Array:
        """Differentiate the physical by the scaled parameters.

        Parameters
        ----------
        theta
            All parameters in their units, shape (n_p,).

        Returns
        -------
        ndarray, shape (n_free,)
            dp/ds: p for a logarithm, w otherwise.
        """
        return np.where(self.log, theta[list(self.free)], self.unit)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of s, shape (n_free,) each; infinite where a parameter has none."""
        lower, upper = self.initial, self.initial
        for i, q in zip(self.free, self.quantities, strict=True):
            lower[i], upper[i] = q.lower, q.upper
        return self.scaled(lower), self.scaled(upper)

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
        for above, below in self.equations.orderings:
            row, limit = np.zeros(len(self.free)), 0.0
            for id, sign in ((above, 1.0), (below, -1.0)):
                quantity = self.equations.parameter(id)
                # A fixed parameter is a constant: it moves to the right-hand side.
                if quantity.fixed:
                    limit -= sign * (math.log(quantity.initial) if quantity.scale == "log" else quantity.initial)
                    continue
                k = self.ids.index(id)
                row[k] = sign * self.unit[k]
                limit -= sign * self.centre[k]
            if row.any():
                rows.append(row)
                limits.append(limit)
        return np.array(rows).reshape(len(limits), len(self.free)), np.array(limits)
