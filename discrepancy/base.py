"""The base fit: homotopy from several starts, so that a stuck optimiser does not pass for missing physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from discrepancy.homotopy import observed, through_homotopy
from discrepancy.solution import Solution, start_vector
from discrepancy.study import Study
from identification.sobol import sobol_starts
from support.errors import NumericalError

AGREE = 2
"""Starts that must reach the best minimum before the rest are left out."""
SAME, ALIKE = 1.0, 1e-3
"""Difference of two costs that count as one minimum: squares over the noise, or share of what is left beyond noise."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    """The base fit with the record of its starts.

    Parameters
    ----------
    solution
        Best minimum.
    costs
        ‖r‖² over all rows of every start, in the order of the starts.
    reached
        How many starts reached the best minimum.
    calls
        Simulations of all runs.
    """

    solution: Solution
    costs: tuple[float, ...]
    reached: int
    calls: int


def agreeing(costs: Sequence[float], rows: int) -> int:
    """Return how many of the costs over ``rows`` rows are the least one."""
    best = min(costs, default=np.inf)
    return sum(cost <= best + max(SAME, ALIKE * (best - rows)) for cost in costs)


def fit_base(study: Study, *, starts: int = 8, seed: int = 0, values: Mapping[str, float] | None = None) -> Base:
    """Fit the base from ``starts`` starts (fewer where `AGREE` of them share the best minimum) under white noise.

    The first start is at ``values`` where given, at the first guesses otherwise.
    """
    first = start_vector(study.base, values or {})
    scaling = observed(study, ()).scaling
    found: list[Solution] = []
    calls = 0
    for theta in sobol_starts(scaling, first, starts, seed):
        named = {q.id: float(p) for q, p in zip(study.base.parameters, theta, strict=True)}
        solution, used = through_homotopy(study, (), named)
        calls += used
        if np.isfinite(solution.chi2):
            found.append(solution)
        if agreeing([s.chi2 for s in found], study.rows) >= AGREE:
            break
    if not found:
        msg = f"{study.title}: no start gave a finite simulation; check units, bounds and first guesses"
        raise NumericalError(msg)
    costs = tuple(s.chi2 for s in found)
    best = min(found, key=lambda s: s.chi2)
    return Base(solution=best, costs=costs, reached=agreeing(costs, study.rows), calls=calls)
