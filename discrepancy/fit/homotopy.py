"""Fit nominal model and effects by homotopy over the observer gain: `Study` and start values in, `Solution` out.

1. Lay out the problem under an observer that holds the simulation near the readings, with weak priors, white noise.
2. Fit under each gain of `GAINS` in turn; with every lower gain the simulation depends more on the model alone.
3. Drop observer and weak priors and fit once more, under white noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.fit.solution import Solution, solve, start_vector
from haptid.discrepancy.fit.whitened import OPTIONS, Whitened
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.optimise.homotopy import feasible, follow_gains
from haptid.identification.optimise.levenberg_marquardt import Descent, SumOfSquares, minimise
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.model.equations.equations import Equations
from haptid.model.equations.quantity import Normal
from haptid.noise.correlation import Noise, Whitener

GAINS = OPTIONS.gains
"""Observer gains of the homotopy, in the order in which they are used [1/s]: those of identification."""
ON_GRID = 1e-9
"""Distance from a grid value, relative to the largest such distance, below which a shape counts as that grid value."""


def lay_out_under_observer(study: Study, effects: Sequence[Effect]) -> Whitened:
    """Lay out the problem of nominal model and effects with weak priors, under white noise.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units.

    Returns
    -------
    Whitened
        Problem whose residuals take an observer gain.
    """
    guided = replace(study, base=with_guides(study.base))
    whiteners = tuple(Whitener() for _ in study.fitted)
    simulator = guided.simulator(effects)
    return Whitened.under(simulator, study.fitted, whiteners, threads=study.threads)


@dataclass(frozen=True, slots=True, kw_only=True)
class Guided:
    """A fit that the observer still guides.

    Parameters
    ----------
    problem
        Problem with weak priors.
    reached
        Minimum under the last gain, with the simulations of all runs so far.
    level
        Number of gains of `GAINS` that the fit has passed.
    """

    problem: Whitened
    reached: Descent
    level: int = 0

    @property
    def values(self) -> dict[str, float]:
        """Parameters that were reached, by id."""
        pairs = zip(self.problem.simulator.equations.parameters, self.problem.theta(self.reached.x), strict=True)
        return {q.id: float(p) for q, p in pairs}

    @property
    def gain(self) -> float:
        """Last gain that the fit has passed [1/s]; the highest before any."""
        return GAINS[max(self.level - 1, 0)]

    def cost_under(self, gain: float) -> float:
        """Return ‖r‖² at the point that was reached, simulated under a gain.

        Parameters
        ----------
        gain
            Observer gain [1/s].

        Returns
        -------
        float
            In squares over the noise, weak priors included; infinite where the simulation diverges.
        """
        residual = self.problem.blocks(self.reached.x, gain, jacobian=False).residual
        cost = float(residual @ residual)
        return cost if np.isfinite(cost) else np.inf

    def linearised(self, effects: Sequence[Effect]) -> Solution:
        """Return the fit with residual and Jacobian under its gain, about which signatures are taken.

        Parameters
        ----------
        effects
            Effects of the fit in SI units.

        Returns
        -------
        Solution
            Under white noise; its residual is what the observer leaves, not that of a free simulation.
        """
        problem, x = self.problem, self.reached.x
        blocks = problem.blocks(x, self.gain)
        return Solution(
            effects=tuple(effects), noise=Noise(), equations=problem.simulator.equations, theta=problem.theta(x),
            x0=problem.x0(x), problem=problem, x=x, raw=blocks, blocks=blocks,
            log_likelihood=-float(blocks.residual @ blocks.residual) / 2.0, calls=1, converged=self.reached.converged,
        )  # fmt: skip

    def down_to(
        self,
        level: int,
        most: int = THRESHOLDS.fit.most_simulations_of_gain,
        tolerance: float = THRESHOLDS.fit.gain_tolerance_chi2,
    ) -> Guided:
        """Fit under the next gains.

        Parameters
        ----------
        level
            Number of gains of `GAINS` that are passed afterwards.
        most
            Largest number of simulations of all runs under one gain.
        tolerance
            Predicted decrease of ‖r‖², in squares over the noise, at which the fit under one gain ends.

        Returns
        -------
        Guided
            Fit at that level, with its simulations added.
        """

        def minimise_level(x: Array, gain: float, _: int) -> Descent:
            return minimise(SumOfSquares.of(self.problem, gain), x, iterations=most, tolerance=tolerance)

        reached = follow_gains(self.reached, GAINS[self.level : level], minimise_level)
        return replace(self, reached=reached, level=level)


def start_under_observer(study: Study, effects: Sequence[Effect], values: Mapping[str, float]) -> Guided:
    """Lay out nominal model and effects under the observer, and start at ``values``.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units.
    values
        Start values of parameters by id; the others start at their first guesses.

    Returns
    -------
    Guided
        Feasible starting point, before any gain.
    """
    problem = lay_out_under_observer(study, effects)
    start = start_vector(problem.simulator.equations, values)
    return Guided(problem=problem, reached=Descent.at(feasible(problem, problem.unknowns_at(start))))


def start_holding_last_shape(study: Study, effects: Sequence[Effect], values: Mapping[str, float]) -> Guided:
    """Start under the observer with a weak prior around the shape of the last effect, as `hold_shapes` gives it.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units, the new one last; none for the nominal model.
    values
        Start values of parameters by id; the others start at their first guesses.

    Returns
    -------
    Guided
        Feasible starting point, before any gain.
    """
    return start_under_observer(study, [*effects[:-1], *(hold_shapes(e, values) for e in effects[-1:])], values)


def at_fine(study: Study, effects: Sequence[Effect], sketched: Guided) -> Guided:
    """Carry a fit from a long inner step over to the inner step of ``study``.

    Parameters
    ----------
    study
        Study at the new inner step.
    effects
        Effects of the fit in SI units.
    sketched
        Fit at the long step.

    Returns
    -------
    Guided
        The same point in a problem at the new step, with 0 simulations.
    """
    reached = replace(sketched.reached, calls=0)
    return replace(sketched, problem=lay_out_under_observer(study, effects), reached=reached)


def release_observer(study: Study, effects: Sequence[Effect], begun: Guided, tolerance: float) -> tuple[Solution, int]:
    """Pass the remaining gains, then fit without observer and weak priors, under white noise.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units.
    begun
        Fit that the observer guides.
    tolerance
        Predicted decrease of ‖r‖², in squares over the noise, at which the last fit ends.

    Returns
    -------
    solution, calls
        Optimum, and the number of simulations of all runs beyond those of ``begun``.
    """
    low = begun.down_to(len(GAINS))
    x0 = low.problem.x0(low.reached.x)
    iterations = THRESHOLDS.fit.most_simulations_of_last_fit
    solution = solve(study, effects, Noise(), low.values, x0=x0, iterations=iterations, tolerance=tolerance)
    return solution, low.reached.calls - begun.reached.calls + solution.calls


def through_homotopy(
    study: Study,
    effects: Sequence[Effect],
    values: Mapping[str, float],
    *,
    tolerance: float = THRESHOLDS.fit.nominal_tolerance_chi2,
) -> tuple[Solution, int]:
    """Fit nominal model and effects through falling observer gains, under white noise.

    Parameters
    ----------
    study
        Study with the fitted runs.
    effects
        Effects in SI units.
    values
        Start values of parameters by id; the others start at their first guesses.
    tolerance
        Predicted decrease of ‖r‖², in squares over the noise, at which the last fit ends.

    Returns
    -------
    solution, calls
        Optimum, and the number of simulations of all runs.
    """
    return release_observer(study, effects, start_under_observer(study, effects, values), tolerance)


def hold_shapes(effect: Effect, values: Mapping[str, float]) -> Effect:
    """Add a weak prior around each shape parameter of an effect.

    Far from the optimum one step may lead to a shape that hardly acts (waves too short for the motion), and no later
    step leads back.

    Parameters
    ----------
    effect
        Effect whose ``shapes`` are the grid.
    values
        Values of the shape parameters by id.

    Returns
    -------
    Effect
        Effect whose shape priors have a standard deviation of half the distance to the next grid value.
    """
    shapes = dict(effect.shapes)
    amplitudes = {q.id for q in effect.parameters[: effect.amplitudes]}
    priors = {}
    for id in shapes.keys() - amplitudes:
        steps = [abs(x - values[id]) for x in shapes[id]]
        # The distance 0 is the grid value itself; only the others say how far the next shape is.
        width = min((x for x in steps if x > ON_GRID * max(steps)), default=0.0) / 2
        priors[id] = Normal(mean=values[id], std=width) if width else None
    return effect.but(parameters=tuple(q.but(prior=priors.get(q.id, q.prior)) for q in effect.parameters))


def with_guides(base: Equations) -> Equations:
    """Add a weak prior around every first guess of the nominal model that has none.

    At a high observer gain some friction parameters hardly act. The prior keeps them from running into a corner (vs and
    Fs without meaning where Fs = Fc) from which no lower gain brings them back. The last fit does without these priors.

    Parameters
    ----------
    base
        Equations of the nominal model.

    Returns
    -------
    Equations
        Equations with weak priors for fits under an observer.
    """
    changes = {}
    for q in base.parameters:
        if q.fixed or q.prior is not None:
            continue
        span = q.upper - q.lower
        if q.scale == "log":
            width = THRESHOLDS.fit.weak_prior_width_over_guess * q.initial
        elif np.isfinite(span):
            width = span / 8
        else:
            width = abs(q.initial) + 1.0
        changes[q.id] = {"prior": Normal(mean=q.initial, std=max(width, 1e-12))}
    return base.with_parameters(changes)
