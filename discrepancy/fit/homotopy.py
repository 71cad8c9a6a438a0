"""Homotopy: an observer holds the simulation near the readings, and lets go while base and effects are fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.fit.solution import Solution, solve, start_vector
from haptid.discrepancy.fit.whitened import Whitened
from haptid.discrepancy.study.study import Study
from haptid.identification.optimise.homotopy import feasible
from haptid.identification.optimise.levenberg_marquardt import minimise
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.noise.correlation import Noise, Whitener

GAINS = (60.0, 20.0, 6.0, 2.0, 0.0)
"""Observer gains of the homotopy [1/s]."""
FEW, MANY, LOOSE = 25, 80, 1.0
"""Most simulations of a level and of the last one, and the tolerance of all but the last, in squares over the noise."""
WIDTH = 0.5
"""Relative width of the weak priors at the upper levels."""
ON_GRID = 1e-9
"""Distance from a shape, in those of its grid, below which both are the same."""


def lay_out_under_observer(study: Study, effects: Sequence[Effect]) -> Whitened:
    """Lay out base and effects with the observer and weak priors, under white noise."""
    guided = replace(study, base=with_guides(study.base))
    whiteners = tuple(Whitener() for _ in study.fitted)
    simulator = guided.simulator(effects)
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

    def down_to(self, level: int, most: int = FEW, tolerance: float = LOOSE) -> Guided:
        """Fit under the next gains, ``level`` of `GAINS` in all, ``most`` simulations under each."""
        x, cost, calls = self.x, self.cost, self.calls
        for gain in GAINS[self.level : level]:
            found = minimise(self.problem, x, gain, iterations=most, tolerance=tolerance)
            x, cost, calls = found.x, found.cost, calls + found.calls
        return replace(self, x=x, cost=cost, level=level, calls=calls)


def start_under_observer(study: Study, effects: Sequence[Effect], values: Mapping[str, float]) -> Guided:
    """Lay out base and effects under the observer, from ``values``."""
    problem = lay_out_under_observer(study, effects)
    start = start_vector(problem.simulator.equations, values)
    return Guided(problem=problem, x=feasible(problem, problem.first(start)))


def at_fine(study: Study, effects: Sequence[Effect], sketched: Guided) -> Guided:
    """Return what was sketched at a long inner step as a fit at that of ``study``, its simulations counted anew."""
    return replace(sketched, problem=lay_out_under_observer(study, effects), calls=0)


def release_observer(study: Study, effects: Sequence[Effect], begun: Guided, tolerance: float) -> tuple[Solution, int]:
    """Go through the gains that are left, then fit without observer, under white noise, to ``tolerance``.

    Returns
    -------
    solution, calls
        Its optimum, and how many simulations of all runs it took beside those of ``begun``.
    """
    low = begun.down_to(len(GAINS))
    x0 = low.problem.x0(low.x)
    solution = solve(study, effects, Noise(), low.values, x0=x0, iterations=MANY, tolerance=tolerance)
    return solution, low.calls - begun.calls + solution.calls


def through_homotopy(
    study: Study, effects: Sequence[Effect], values: Mapping[str, float], *, tolerance: float = 0.01
) -> tuple[Solution, int]:
    """Fit base and effects from ``values`` through falling observer gains, under white noise, to ``tolerance``.

    Returns
    -------
    solution, calls
        Its optimum, and how many simulations of all runs it took.
    """
    return release_observer(study, effects, start_under_observer(study, effects, values), tolerance)


def hold_shapes(effect: Effect, values: Mapping[str, float]) -> Effect:
    """Return the effect with a weak prior around each shape in ``values``, half a step of its grid wide.

    Far from the optimum one step may lead to where the shape hardly acts (waves too short for the motion), and no later
    one leads back.
    """
    shapes = dict(effect.shapes)
    amplitudes = {q.id for q in effect.parameters[: effect.amplitudes]}
    priors = {}
    for id in shapes.keys() - amplitudes:
        steps = [abs(x - values[id]) for x in shapes[id]]
        width = min((x for x in steps if x > ON_GRID * max(steps)), default=0.0) / 2
        priors[id] = Normal(mean=values[id], std=width) if width else None
    return effect.but(parameters=tuple(q.but(prior=priors.get(q.id, q.prior)) for q in effect.parameters))


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
