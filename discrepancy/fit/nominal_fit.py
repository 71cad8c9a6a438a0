"""The base fit: homotopy from several starts, so that a stuck optimiser does not pass for missing physics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.fit.homotopy import lay_out_under_observer, through_homotopy
from haptid.discrepancy.fit.solution import Solution, start_vector
from haptid.discrepancy.study.study import Study
from haptid.identification.optimise.starts import sobol_starts
from haptid.measurement.values.run import Array
from haptid.support.errors import NumericalError
from haptid.support.processes.threads import map_threads

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
    scaling = lay_out_under_observer(study, ()).scaling
    found: list[Solution] = []
    calls = 0
    for solution, used in _fits(study, sobol_starts(scaling, first, starts, seed)):
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


def _fits(study: Study, starts: Sequence[Array]) -> Iterator[tuple[Solution, int]]:
    """Yield the fit from each start with its cost, `AGREE` of them side by side: so many are needed at least."""
    alone = replace(study, threads=1) if len(starts) > 1 else study

    def one(theta: Array) -> tuple[Solution, int]:
        named = {q.id: float(p) for q, p in zip(study.base.parameters, theta, strict=True)}
        return through_homotopy(alone, (), named)

    for k in range(0, len(starts), AGREE):
        yield from map_threads(one, starts[k : k + AGREE], threads=study.threads)
