"""Choice of the noise model by its log predictive density of held-out runs: `Problem` in, `Scored` models out.

1. For every candidate, the simplest first, find the mode from the mode of the candidate before.
2. Draw parameters from the normal approximation, and average the density of the held-out runs over the draws.
3. Choose the simplest model whose score is within `THRESHOLDS.least_gain_of_held_out_score` of the best.

References
----------
Kass, R. E., and Raftery, A. E. (1995). Bayes factors. Journal of the American Statistical Association 90, 773–795.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run
from haptid.noise.noise_model import NoiseModel, candidates
from haptid.noise.terms import Terms, prepare
from haptid.support.errors import NumericalError
from haptid.uq.density.coordinates import Coordinates
from haptid.uq.density.density import Density
from haptid.uq.density.forward import Forward
from haptid.uq.density.laplace import THOROUGH, Climb, Laplace, laplace
from haptid.uq.density.likelihood import predictive_score
from haptid.uq.density.normal_equations import expand
from haptid.uq.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """Inference problem of one joint.

    Parameters
    ----------
    simulator
        Simulator with sensitivities, for the mode.
    forward
        Simulation of many parameter sets, for the density.
    fitted, unseen
        Runs that are fitted, and held-out runs that choose the noise model.
    noise_width
        Standard deviation of ln(noise factor) in its prior [1].
    widen
        Factor on the width of every prior [1].
    climb
        How far the climbs to modes go.
    """

    simulator: Simulator
    forward: Forward
    fitted: tuple[Run, ...]
    unseen: tuple[Run, ...]
    noise_width: float
    widen: float = 1.0
    climb: Climb = THOROUGH

    @property
    def travel(self) -> float:
        """Largest travel of a fitted run, or range of its torques, in the unit of the readings."""
        return max(float(np.ptp(run.y[:, 0])) for run in self.fitted)

    def density(self, model: NoiseModel) -> Density:
        """Return the posterior density under a noise model, not yet linearised.

        Parameters
        ----------
        model
            Noise model.

        Returns
        -------
        Density
            Of the fitted runs.
        """
        equations = self.simulator.equations
        hyper = model.hyper(noise_width=self.noise_width, travel=self.travel, unit=equations.outputs[0].unit)
        return Density(
            coordinates=Coordinates.of(equations, hyper=hyper, widen=self.widen),
            model=model,
            terms=tuple(prepare(equations, run) for run in self.fitted),
            forward=self.forward,
        )

    def mode(self, model: NoiseModel, theta: Array, hyper: dict[str, float] | None = None) -> Laplace:
        """Find the mode under a noise model, the best of climbs from one or more starts.

        Parameters
        ----------
        model
            Noise model.
        theta
            Start of the equations' parameters, shape (n_p,).
        hyper
            Starts of the noise model's parameters by id; each `Hyper`'s own where absent.

        Returns
        -------
        Laplace
            The mode of largest density with the normal approximation there.

        Raises
        ------
        NumericalError
            Where no climb reaches a finite density.
        """
        return self.mode_from(model, theta, _noise_starts(model, hyper or {}))

    def mode_from(self, model: NoiseModel, theta: Array, starts: Sequence[dict[str, float]]) -> Laplace:
        """Find the mode under a noise model, the best of climbs from given starts of the noise model's parameters.

        Parameters
        ----------
        model, theta
            As for `mode`.
        starts
            Starts of the noise model's parameters by id; each `Hyper`'s own where absent.

        Returns
        -------
        Laplace
            As `mode` returns it.

        Raises
        ------
        NumericalError
            Where no climb reaches a finite density.
        """
        density = self.density(model)
        found, failed = [], None
        for assumed in starts:
            start = np.array([assumed.get(h.id, h.start) for h in density.coordinates.hyper])
            try:
                found.append(laplace(density, self.simulator, density.coordinates.eta(theta, start), climb=self.climb))
            except NumericalError as error:
                failed = error
        if not found and failed is not None:
            raise failed
        return max(found, key=lambda mode: mode.log_density)


def _noise_starts(model: NoiseModel, hyper: dict[str, float]) -> list[dict[str, float]]:
    """Return starts of the noise model's parameters.

    Where the residual of the candidate before was larger than the sensor noise, two starts with a large scatter are
    added, at the stated noise and at five times it: there the scatter explains variation that a least-squares fit had
    absorbed into the parameters.
    """
    if model.scatter == "none" or hyper.get("noise_factor", 1.0) < THRESHOLDS.least_noise_factor_of_scatter:
        return [hyper]
    return [hyper, *(hyper | {"noise_factor": nu, "cycle_scatter": s} for nu, s in ((1.0, 0.1), (5.0, 0.05)))]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """A noise model with its normal approximation and its score.

    Parameters
    ----------
    model
        Noise model.
    mode
        Normal approximation under the model.
    score
        Log predictive density of the held-out runs [1].
    """

    model: NoiseModel
    mode: Laplace
    score: float


def unseen_terms(mode: Laplace, simulator: Simulator, runs: Sequence[Run]) -> tuple[Terms, ...]:
    """Make held-out runs ready for their likelihood, their starts and columns linearised at the mode.

    Parameters
    ----------
    mode
        Normal approximation of the posterior.
    simulator
        Simulator with sensitivities.
    runs
        Held-out runs.

    Returns
    -------
    tuple of Terms
        One a run, in their order, each start at its conditional mean given the run's own readings.
    """
    density = mode.density.but(terms=tuple(prepare(simulator.equations, run) for run in runs))
    for _ in range(2):  # each pass moves the starts to their conditional means; the columns are then taken there
        density = expand(density.linearise(simulator, mode.eta), simulator, mode.eta).density
    return density.linearise(simulator, mode.eta).terms


def held_out_score(mode: Laplace, simulator: Simulator, runs: Sequence[Run], draws: Array) -> float:
    """Return the log of the posterior mean of the held-out runs' density.

    Parameters
    ----------
    mode
        Normal approximation, at which the held-out runs are linearised.
    simulator
        Simulator with sensitivities.
    runs
        Held-out runs.
    draws
        Draws of η, shape (n_draws, n).

    Returns
    -------
    float
        ln (1/n_draws·Σ p(runs | η)); only the scored rows of a run count.
    """
    density = mode.density
    thetas, hyper = density.coordinates.thetas(draws), density.hyper(draws)
    total = np.zeros(len(draws))
    for terms in unseen_terms(mode, simulator, runs):
        simulated = density.simulate(draws, terms)
        total += predictive_score(terms, density.model, density.equations, thetas, hyper, simulated)
    return float(logsumexp(total) - np.log(total.size))


def normal_draws(mode: Laplace, rng: np.random.Generator, size: int = THRESHOLDS.draws_of_held_out_score) -> Array:
    """Draw from the normal approximation inside the prior's support.

    Parameters
    ----------
    mode
        Normal approximation of the posterior.
    rng
        Source of the random numbers.
    size
        Largest number of draws.

    Returns
    -------
    ndarray, shape (n_draws, n)
        At most ``size`` draws; the mode itself where none of 8·``size`` lies inside.
    """
    drawn = mode.eta + rng.standard_normal((8 * size, mode.eta.size)) @ mode.lower.T
    inside = drawn[np.isfinite(mode.density.coordinates.log_prior(drawn))][:size]
    return inside if len(inside) else mode.eta[None]


def _tell_nobody(figures: str) -> None:
    """Take which candidate is scored, and do nothing."""


def compare(
    problem: Problem, theta: Array, *, white: Laplace | None = None, seed: int = 0,
    tell: Callable[[str], None] = _tell_nobody,
) -> tuple[Scored, ...]:  # fmt: skip
    """Score every candidate noise model, the simplest first, each started from the mode of the candidate before.

    Short climbs (`Problem.climb`) score those with a correlated model error before those with a scatter alone.

    Parameters
    ----------
    problem
        Runs and simulator.
    theta
        Start of the equations' parameters for the first candidate, shape (n_p,).
    white
        Mode of ``problem`` under white noise from ``theta``, the first candidate; climbed to here where None.
    seed
        Seed of the draws; every candidate has the same random numbers.
    tell
        Told which candidate is scored, as ``model 2 of 6``.

    Returns
    -------
    tuple of Scored
        Without candidates that have no mode.

    Raises
    ------
    NumericalError
        Where the simplest candidate has no mode.
    """
    # A torque that is read along the measured motion has no cycles whose amplitude could scatter.
    moves = bool(problem.simulator.equations.joints)
    cycles = sum(t.cycles for t in problem.density(NoiseModel()).terms) if moves else 0
    models = candidates(len(problem.fitted), cycles)
    short = problem.climb != THOROUGH
    scored: dict[NoiseModel, Scored] = {}
    hyper: dict[str, float] = {}
    number = 0
    for chain in _chains(models) if short else (models,):
        if scored:
            first = scored[models[0]].mode
            theta, hyper = first.density.coordinates.thetas(first.eta), _hyper_of(first)
        for model in chain:
            number += 1
            tell(f"model {number} of {len(models)}")
            asked = _with_worth(problem, scored.values()) if short else problem
            try:
                mode = white if white is not None and not scored else asked.mode(model, theta, hyper)
                if model.correlated and _leaves_more_than_noise(scored[models[0]].mode):
                    mode = _better_from_white_noise(asked, mode, scored[models[0]].mode)
            except NumericalError:
                if not scored:
                    raise
                continue  # a model without a mode explains nothing here; the others are compared
            rng = np.random.default_rng([seed, 7])  # the same for every candidate: scores differ by the models alone
            score = held_out_score(mode, problem.simulator, problem.unseen, normal_draws(mode, rng))
            scored[model] = Scored(model=model, mode=mode, score=score)
            theta = mode.density.coordinates.thetas(mode.eta)
            hyper = hyper | _hyper_of(mode)
    return tuple(scored[model] for model in models if model in scored)


def _chains(models: Sequence[NoiseModel]) -> tuple[tuple[NoiseModel, ...], ...]:
    """Divide candidates into those that follow one another's modes where climbs are short, each chain from white noise.

    A correlated model error comes first: where the model lacks something, it is far ahead of every scatter alone, whose
    climbs wander longest and then end early (`_with_worth`).
    """
    white, *others = models
    return (white, *(m for m in others if m.correlated)), tuple(m for m in others if not m.correlated)


def _with_worth(problem: Problem, scored: Iterable[Scored]) -> Problem:
    """Return the problem with climbs that end where they stay far below the best mode so far."""
    best_so_far = max((one.mode.log_density for one in scored), default=-np.inf)
    worth = best_so_far - THRESHOLDS.least_shortfall_of_hopeless_model
    return replace(problem, climb=replace(problem.climb, worth=worth))


def refine(problem: Problem, scored: Scored) -> Scored:
    """Climb to the mode of a scored noise model under another problem, from the mode where it was scored.

    Parameters
    ----------
    problem
        Problem of the same runs and equations, simulated with another inner step.
    scored
        Scored noise model.

    Returns
    -------
    Scored
        With the mode under ``problem`` and the old score.

    Raises
    ------
    NumericalError
        As `Problem.mode`.
    """
    mode = scored.mode
    theta, hyper = mode.density.coordinates.thetas(mode.eta), _hyper_of(mode)
    return replace(scored, mode=problem.mode_from(scored.model, theta, [hyper]))


def _hyper_of(mode: Laplace) -> dict[str, float]:
    """Return the values of the noise model's parameters at the mode, by id."""
    return {name: float(value[0]) for name, value in mode.density.hyper(mode.eta[None]).items()}


def _leaves_more_than_noise(white: Laplace) -> bool:
    """Say whether the mode under white noise leaves a residual larger than the sensor noise."""
    return _hyper_of(white)["noise_factor"] >= THRESHOLDS.least_noise_factor_of_scatter


def _better_from_white_noise(problem: Problem, mode: Laplace, white: Laplace) -> Laplace:
    """Return the better of a mode and of one that is reached from the mode under white noise.

    A scatter that stands in for what the model lacks leads the parameters away from the fit, sometimes for good.
    """
    try:
        other = problem.mode(mode.density.model, white.density.coordinates.thetas(white.eta))
    except NumericalError:
        return mode
    return max(mode, other, key=lambda one: one.log_density)


def best(scored: Sequence[Scored]) -> Scored:
    """Return the first (simplest) noise model whose score is close enough to the best.

    Parameters
    ----------
    scored
        Scored models, the simplest first.

    Returns
    -------
    Scored
        Its score is below the highest by at most `THRESHOLDS.least_gain_of_held_out_score`.
    """
    top = max(s.score for s in scored)
    return next(s for s in scored if s.score >= top - THRESHOLDS.least_gain_of_held_out_score)
