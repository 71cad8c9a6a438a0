"""Scaled parameters: what an optimiser moves, against what the equations take.

s = ln p for a quantity of scale ``log``, s = (p − p₀)/w otherwise, with p₀ the first guess and w the prior's standard
deviation, a quarter of the range, or the first guess, whichever is the first that exists.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Quantity

WIDEST = 1e6
"""A linear range wider than this many first guesses says nothing about the size of the quantity."""


def linear_unit(quantity: Quantity) -> float:
    """Return the typical size w of a quantity of linear scale, in its own unit."""
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
        Whose parameters these are.
    free
        Indices of the parameters that are fitted, ascending, shape (n_free,).
    log
        Which of them are logarithms, shape (n_free,).
    centre, unit
        p₀ and w of the linear ones (0 and 1 of the logarithms), shape (n_free,).
    """

    equations: Equations
    free: tuple[int, ...]
    log: tuple[bool, ...]
    centre: Array
    unit: Array

    @classmethod
    def of(cls, equations: Equations) -> Scaling:
        """Scale every parameter that is not fixed."""
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
        """Return s (n_free,) of the parameters theta (n_p,)."""
        p = np.asarray(theta, dtype=np.float64)[list(self.free)]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(p), (p - self.centre) / self.unit)

    def physical(self, s: Array) -> Array:
        """Return theta (n_p,) of s (n_free,); the fixed parameters keep their first guesses.

        Rounding takes no parameter beyond its bounds.
        """
        theta = self.initial
        with np.errstate(over="ignore"):
            moved = np.where(self.log, np.exp(s), self.centre + self.unit * s)
        lower, upper = np.array([(q.lower, q.upper) for q in self.quantities]).reshape(-1, 2).T
        theta[list(self.free)] = np.clip(moved, lower, upper)
        return theta

    def slope(self, theta: Array) -> Array:
        """Return dp/ds of the free parameters at theta, shape (n_free,)."""
        return np.where(self.log, theta[list(self.free)], self.unit)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of s, shape (n_free,) each; infinite where there is none."""
        lower, upper = self.initial, self.initial
        for i, q in zip(self.free, self.quantities, strict=True):
            lower[i], upper[i] = q.lower, q.upper
        return self.scaled(lower), self.scaled(upper)

    def orderings(self) -> tuple[Array, Array]:
        """Return A (n, n_free) and b (n,) with A·s ≥ b where pairs of parameters must keep their order."""
        rows, limits = [], []
        for above, below in self.equations.orderings:
            row, limit = np.zeros(len(self.free)), 0.0
            for id, sign in ((above, 1.0), (below, -1.0)):
                quantity = self.equations.parameter(id)
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
