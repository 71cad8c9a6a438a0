"""The base fit: homotopy from several starts, so that a stuck optimiser does not pass for missing physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from discrepancy.levenberg import minimise
from discrepancy.noise import Noise, Whitener
from discrepancy.solution import Solution, solve, start_vector
from discrepancy.study import Study
from discrepancy.whitened import Whitened
from identification.homotopy import feasible
from identification.sobol import sobol_starts
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
SAME = 1.0
"""Difference of two costs (squares over the noise) that count as one minimum."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    """The base fit with the record of its starts.

    Parameters
    ----------
    solution
        Best minimum.
    costs
        ‖r‖² over rows of every start, in the order of the starts.
    calls
        Simulations of all runs.
    """

    solution: Solution
    costs: tuple[float, ...]
    calls: int

    @property
    def reached(self) -> int:
        """How many starts reached the best minimum."""
        best = min(self.costs)
        return sum(cost <= best + SAME for cost in self.costs)


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
        best = min((s.chi2 for s in found), default=np.inf)
        if sum(s.chi2 <= best + SAME for s in found) >= AGREE:
            break
    if not found:
        msg = f"joint {study.joint}: no start gave a finite simulation; check units, bounds and first guesses"
        raise NumericalError(msg)
    return Base(solution=min(found, key=lambda s: s.chi2), costs=tuple(s.chi2 for s in found), calls=calls)


def _guided(study: Study, effects: Sequence[Effect]) -> Whitened:
    guided = replace(study, base=with_guides(study.base))
    whiteners = tuple(Whitener() for _ in study.fitted)
    simulator = guided.simulator(effects, observed=True)
    return Whitened.under(simulator, study.fitted, whiteners, threads=study.threads)


def through_homotopy(
    study: Study, effects: Sequence[Effect], values: Mapping[str, float], *, tolerance: float = 0.01
) -> tuple[Solution, int]:
    """Fit base and effects from ``values`` through falling observer gains, under white noise, to ``tolerance``.

    Returns
    -------
    solution, calls
        Its optimum, and how many simulations of all runs it took.
    """
    problem = _guided(study, effects)
    equations = problem.simulator.equations
    x, calls = feasible(problem, problem.first(start_vector(equations, values))), 0
    for gain in GAINS:
        level = minimise(problem, x, gain, iterations=FEW, tolerance=LOOSE)
        x, calls = level.x, calls + level.calls
    named = {q.id: float(p) for q, p in zip(equations.parameters, problem.theta(x), strict=True)}
    solution = solve(study, effects, Noise(), named, x0=problem.x0(x), iterations=MANY, tolerance=tolerance)
    return solution, calls + solution.calls


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
