"""Which noise model the data ask for: the one that best predicts runs that no fit saw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
from haptid.uq.density.laplace import Laplace, laplace
from haptid.uq.density.likelihood import predictive_score
from haptid.uq.density.normal_equations import expand

DRAWS = 64
UNEXPLAINED = 1.2
"""Noise factor from which a noise model counts as not explaining the data."""
MARGIN = 3.0
"""Gain in held-out log predictive density below which the simpler model is kept: what Kass and Raftery (1995) call
strong, for the best of six alternatives gains one or two by chance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """Runs of one joint, a simulator, and how wide the prior of the noise factor is."""

    simulator: Simulator
    forward: Forward
    fitted: tuple[Run, ...]
    unseen: tuple[Run, ...]
    noise_width: float
    widen: float = 1.0

    @property
    def travel(self) -> float:
        """Largest travel of a fitted run [rad]."""
        return max(float(np.ptp(run.y[:, 0])) for run in self.fitted)

    def density(self, model: NoiseModel) -> Density:
        """Posterior density under ``model``, not yet linearised."""
        equations = self.simulator.equations
        hyper = model.hyper(noise_width=self.noise_width, travel=self.travel)
        return Density(
            coordinates=Coordinates(equations=equations, hyper=hyper, widen=self.widen),
            model=model,
            terms=tuple(prepare(equations, run) for run in self.fitted),
            forward=self.forward,
        )

    def mode(self, model: NoiseModel, theta: Array, hyper: dict[str, float] | None = None) -> Laplace:
        """Climb from θ and known values of the noise model's parameters to the mode under ``model``."""
        density = self.density(model)
        found, failed = [], None
        for assumed in _noise_starts(model, hyper or {}):
            start = np.array([assumed.get(h.id, h.start) for h in density.coordinates.hyper])
            try:
                found.append(laplace(density, self.simulator, density.coordinates.eta(theta, start)))
            except NumericalError as error:
                failed = error
        if not found and failed is not None:
            raise failed
        return max(found, key=lambda mode: mode.log_density)


def _noise_starts(model: NoiseModel, hyper: dict[str, float]) -> list[dict[str, float]]:
    """Values of the noise model's parameters to climb from.

    Where the model before left more than noise, also from true noise with a large scatter, and from a way between: the
    scatter then takes up what a least-squares fit had put into the parameters.
    """
    if model.scatter == "none" or hyper.get("noise_factor", 1.0) < UNEXPLAINED:
        return [hyper]
    return [hyper, *(hyper | {"noise_factor": nu, "cycle_scatter": s} for nu, s in ((1.0, 0.1), (5.0, 0.05)))]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """A noise model, its normal approximation, and its log predictive density of the unseen runs."""

    model: NoiseModel
    mode: Laplace
    score: float


def unseen_terms(mode: Laplace, simulator: Simulator, runs: Sequence[Run]) -> tuple[Terms, ...]:
    """Terms of runs that were not fitted, their starts and columns linearised at the mode."""
    density = mode.density.but(terms=tuple(prepare(simulator.equations, run) for run in runs))
    for _ in range(2):
        density = expand(density.linearised(simulator, mode.eta), simulator, mode.eta).density
    return density.linearised(simulator, mode.eta).terms


def held_out_score(mode: Laplace, simulator: Simulator, runs: Sequence[Run], draws: Array) -> float:
    """Log of the posterior mean of p(unseen runs | η) over ``draws`` (n_draws, n)."""
    density = mode.density
    thetas, hyper = density.coordinates.thetas(draws), density.hyper(draws)
    total = np.zeros(len(draws))
    for terms in unseen_terms(mode, simulator, runs):
        simulated = density.simulated(draws, terms)
        total += predictive_score(terms, density.model, density.equations, thetas, hyper, simulated)
    return float(logsumexp(total) - np.log(total.size))


def normal_draws(mode: Laplace, rng: np.random.Generator, size: int = DRAWS) -> Array:
    """Draws of the normal approximation inside the prior's support."""
    drawn = mode.eta + rng.standard_normal((8 * size, mode.eta.size)) @ mode.lower.T
    inside = drawn[np.isfinite(mode.density.coordinates.log_prior(drawn))][:size]
    return inside if len(inside) else mode.eta[None]


def compare(problem: Problem, theta: Array, *, seed: int = 0) -> tuple[Scored, ...]:
    """Score every candidate, each started from the mode of the one before, the simplest first."""
    cycles = sum(t.cycles for t in problem.density(NoiseModel()).terms)
    scored: list[Scored] = []
    hyper: dict[str, float] = {}
    for model in candidates(len(problem.fitted), cycles):
        try:
            mode = problem.mode(model, theta, hyper)
        except NumericalError:
            if not scored:
                raise
            continue  # a model without a mode explains nothing here; the others are compared
        rng = np.random.default_rng([seed, 7])
        score = held_out_score(mode, problem.simulator, problem.unseen, normal_draws(mode, rng))
        scored.append(Scored(model=model, mode=mode, score=score))
        theta = mode.density.coordinates.thetas(mode.eta)
        hyper |= {name: float(value[0]) for name, value in mode.density.hyper(mode.eta[None]).items()}
    return tuple(scored)


def best(scored: Sequence[Scored]) -> Scored:
    """Return the first (simplest) model within ``MARGIN`` of the best score."""
    top = max(s.score for s in scored)
    return next(s for s in scored if s.score >= top - MARGIN)
