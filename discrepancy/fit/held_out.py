"""Runs that no fit saw: their log predictive score and their RMS error, the initial position profiled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from haptid.discrepancy.fit.discontinuity import places
from haptid.discrepancy.fit.solution import Solution, under_noise, with_starts
from haptid.discrepancy.study.channels import scored_rows
from haptid.discrepancy.study.study import Study
from haptid.identification.optimise.levenberg_marquardt import minimise
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Colour, Noise

SPREAD, SHARE = 5.0, 0.05
"""How far ‖r‖² of unseen runs may lie above its mean for noise alone."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """How a solution predicts some runs.

    Parameters
    ----------
    score
        Log predictive score Σ −½(‖r‖² + ln det C), whitened residuals r under the noise model.
    rms
        RMS of measured − simulated over the scored rows of every run [rad].
    y
        Simulated readings of every run, shape (n_t, n_joints).
    chi2, rows
        ‖r‖² over all runs, and how many rows count.
    excess
        Largest relative excess of a run's mean square over the sensor's noise, beyond `SPREAD` of its standard
        deviations, where that noise is stated; 0 otherwise. What scatters is whitened, what is correlated is not.
    """

    score: float
    rms: tuple[float, ...]
    y: tuple[Array, ...]
    chi2: float = 0.0
    rows: int = 0
    excess: float = 0.0

    @property
    def noise_alone(self) -> bool:
        """Whether ‖r‖² is what noise gives: within `SPREAD` of its standard deviations and `SHARE` of its mean.

        The share leaves room for what a fit's uncertainty and the noise model's own add on runs that no fit saw.
        """
        return self.chi2 <= self.rows * (1.0 + SHARE) + SPREAD * float(np.sqrt(2.0 * self.rows))


def predict(
    study: Study, solution: Solution, runs: Sequence[Run] | None = None, *, noise: Noise | None = None
) -> Prediction:
    """Predict ``runs`` (by default the unseen ones) with the fitted parameters, under ``noise`` (default its own).

    Where a jump may lie at several places as far as the fitted runs tell, the score is that of their mixture, ‖r‖² that
    of the best; readings and RMS are those of the fitted one.
    """
    chosen = tuple(study.unseen if runs is None else runs)
    model = solution.noise if noise is None else noise
    if not chosen:
        return Prediction(score=0.0, rms=(), y=())
    found = [_at(study, solution, theta, chosen, model) for theta in places(solution, study.fitted, chosen)]
    scores = [p.score for p in found]
    score = float(logsumexp(scores) - np.log(len(scores)))
    return replace(found[0], score=score, chi2=min(p.chi2 for p in found), excess=min(p.excess for p in found))


def _at(study: Study, solution: Solution, theta: Array, runs: Sequence[Run], model: Noise) -> Prediction:
    """Predict with the parameters ``theta``."""
    held = {q.id: {"initial": float(p), "lower": float(p), "upper": float(p), "fixed": True}
            for q, p in zip(solution.equations.parameters, theta, strict=True)}  # fmt: skip
    simulator = study.factory(solution.equations.with_parameters(held))
    problem = under_noise(simulator, runs, model.but(scatters=()), theta, (), threads=study.threads)
    x = minimise(problem, np.zeros(problem.size), iterations=12).x
    x0 = problem.x0(x)
    if model.scatters:
        problem = under_noise(simulator, runs, model, theta, x0, threads=study.threads)
        x = minimise(problem, with_starts(problem, np.zeros(problem.size), x0), iterations=12).x
        x0 = problem.x0(x)
    found = problem.blocks(x, jacobian=False)
    chi2 = float(found.residual @ found.residual)
    y = tuple(simulator.simulate(theta, run, x0=start).y for run, start in zip(runs, x0, strict=True))
    left = [(run.y - s)[run.scored] for run, s in zip(runs, y, strict=True)]
    rms = tuple(float(np.sqrt(np.mean(e**2))) for e in left)
    rows = sum(scored_rows(run) for run in runs)
    stated, excess = model.but(colour=Colour()), 0.0
    if study.noise_given and model == stated:
        excess = _excess(runs, found.rows)
    elif study.noise_given:
        problem_stated = under_noise(simulator, runs, stated, theta, x0, threads=study.threads)
        at = with_starts(problem_stated, np.zeros(problem_stated.size), x0)
        excess = _excess(runs, problem_stated.blocks(at, jacobian=False).rows)
    score = -0.5 * (chi2 + problem.log_determinant)
    return Prediction(score=score, rms=rms, y=y, chi2=chi2, rows=rows, excess=excess)


def _excess(runs: Sequence[Run], whitened: Sequence[Array]) -> float:
    """Return the largest excess of a run's mean square over the stated noise, beyond chance."""
    powers = [float((r**2).sum()) / scored_rows(run) - 1.0 for r, run in zip(whitened, runs, strict=True)]
    chance = [SPREAD * np.sqrt(2.0 / scored_rows(run)) for run in runs]
    return max(0.0, *(float(p - c) for p, c in zip(powers, chance, strict=True)))
