"""The base fit: homotopy from several starts, so that a stuck optimiser does not pass for missing physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.levenberg import minimise
from discrepancy.noise import Noise, Whitener
from discrepancy.solution import Solution, solve, start_vector, with_starts
from discrepancy.study import Study
from discrepancy.whitened import Whitened
from identification.homotopy import feasible
from identification.sobol import sobol_starts
from measurement.run import Array
from model.effect import Effect
from model.equations import Equations
from model.quantity import Normal
from support.errors import NumericalError

GAINS = (60.0, 20.0, 6.0, 2.0, 0.0)
"""Observer gains of the homotopy [1/s]."""
FEW, MANY, LOOSE = 25, 80, 1.0
"""Most simulations of a level and of the last one, and the tolerance of all but the last, in squares over the noise."""
WIDTH = 0.5
"""Relative width of the weak priors at the upper levels."""
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
    scaling = _guided(study, ()).scaling
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
        msg = f"joint {study.joint}: no start gave a finite simulation; check units, bounds and first guesses"
        raise NumericalError(msg)
    costs = tuple(s.chi2 for s in found)
    best = min(found, key=lambda s: s.chi2)
    return Base(solution=best, costs=costs, reached=agreeing(costs, study.rows), calls=calls)


def _guided(study: Study, effects: Sequence[Effect]) -> Whitened:
    guided = replace(study, base=with_guides(study.base))
    whiteners = tuple(Whitener() for _ in study.fitted)
    simulator = guided.simulator(effects, observed=True)
    return Whitened.under(simulator, study.fitted, whiteners, threads=study.threads)


@dataclass(frozen=True, slots=True, kw_only=True)
class Guided:
    """A fit that the observer still guides.

    Parameters
    ----------
    problem, x
        The problem and the point that was reached.
    cost
        ‖r(x)‖² under the last gain.
    level
        Number of gains of `GAINS` that are behind it.
    calls
        Simulations of all runs so far.
    """

    problem: Whitened
    x: Array
    cost: float = np.inf
    level: int = 0
    calls: int = 0

    @property
    def values(self) -> dict[str, float]:
        """Parameters at x by id."""
        pairs = zip(self.problem.simulator.equations.parameters, self.problem.theta(self.x), strict=True)
        return {q.id: float(p) for q, p in pairs}

    def down_to(self, level: int, most: int = FEW) -> Guided:
        """Fit under the next gains, ``level`` of `GAINS` in all, ``most`` simulations under each."""
        x, cost, calls = self.x, self.cost, self.calls
        for gain in GAINS[self.level : level]:
            found = minimise(self.problem, x, gain, iterations=most, tolerance=LOOSE)
            x, cost, calls = found.x, found.cost, calls + found.calls
        return replace(self, x=x, cost=cost, level=level, calls=calls)


def guided(study: Study, effects: Sequence[Effect], values: Mapping[str, float], begun: Guided | None = None) -> Guided:
    """Lay out base and effects under the observer, from ``values``; at the last level of a ``begun`` fit with fewer."""
    problem = _guided(study, effects)
    x = problem.first(start_vector(problem.simulator.equations, values))
    if begun is None:
        return Guided(problem=problem, x=feasible(problem, x))
    x = with_starts(problem, x, begun.problem.x0(begun.x))
    return Guided(problem=problem, x=feasible(problem, x), level=begun.level - 1)


def released(study: Study, effects: Sequence[Effect], begun: Guided, tolerance: float) -> tuple[Solution, int]:
    """Go through the gains that are left, then fit without observer, under white noise, to ``tolerance``.

    Returns
    -------
    solution, calls
        Its optimum, and how many simulations of all runs it took, ``begun`` included.
    """
    low = begun.down_to(len(GAINS))
    x0 = low.problem.x0(low.x)
    solution = solve(study, effects, Noise(), low.values, x0=x0, iterations=MANY, tolerance=tolerance)
    return solution, low.calls + solution.calls


def through_homotopy(
    study: Study, effects: Sequence[Effect], values: Mapping[str, float], *, tolerance: float = 0.01
) -> tuple[Solution, int]:
    """Fit base and effects from ``values`` through falling observer gains, under white noise, to ``tolerance``.

    Returns
    -------
    solution, calls
        Its optimum, and how many simulations of all runs it took.
    """
    return released(study, effects, guided(study, effects, values), tolerance)


def with_guides(base: Equations) -> Equations:
    """Return the base with a weak prior around every first guess that has none.

    At a high observer gain some of friction's parameters hardly act; the prior keeps them from running into a corner
    (vs and Fs without meaning where Fs = Fc) from which no lower gain brings them back. The last level does without.
    """
    changes = {}
    for q in base.parameters:
        if q.fixed or q.prior is not None:
            continue
        span = q.upper - q.lower
        width = WIDTH * q.initial if q.scale == "log" else span / 8 if np.isfinite(span) else abs(q.initial) + 1.0
        changes[q.id] = {"prior": Normal(mean=q.initial, std=max(width, 1e-12))}
    return base.with_parameters(changes)
