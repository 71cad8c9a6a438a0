"""Predict held-out runs with a fitted model: `Solution` and `Run`s in, `Prediction` out.

1. Hold all parameters and fit the initial states alone, without scatter.
2. With scatter, linearise it about that trajectory and fit the initial states once more.
3. Score the whitened residual, and take the RMS of measured − simulated.
4. Where a discontinuity may lie at several places, average the predictive densities over these places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from haptid.discrepancy.fit.discontinuity import places
from haptid.discrepancy.fit.solution import Solution, under_noise, with_starts
from haptid.discrepancy.study.channels import scored_rows
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.optimise.levenberg_marquardt import SumOfSquares, minimise
from haptid.measurement.values.run import Array, Run
from haptid.noise.correlation import Arma, Noise
from haptid.support.linear_algebra import rms


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """How a solution predicts some runs.

    Parameters
    ----------
    score
        Log predictive score Σ −½(‖r‖² + ln det C), with whitened residuals r under the noise model.
    rms
        RMS of measured − simulated over the scored rows of every run [rad], [m] for a prismatic joint.
    y
        Simulated readings of every run, shape (n_t, n_joints).
    chi2
        ‖r‖² over all runs.
    rows
        Number of scored residuals.
    excess
        Largest relative excess of a run's mean square over the stated sensor noise, beyond
        `largest_held_out_excess_in_std` of its standard deviations; 0 where the campaign states no noise. Scatter is
        whitened first, correlation is not.
    """

    score: float
    rms: tuple[float, ...]
    y: tuple[Array, ...]
    chi2: float = 0.0
    rows: int = 0
    excess: float = 0.0

    @property
    def noise_alone(self) -> bool:
        """Whether ‖r‖² is as large as noise makes it: within some standard deviations plus a share of its mean.

        The share leaves room for the uncertainty of the fit and of the noise model on held-out runs.
        """
        chance = THRESHOLDS.fit.largest_held_out_excess_in_std * float(np.sqrt(2.0 * self.rows))
        return self.chi2 <= self.rows * (1.0 + THRESHOLDS.fit.largest_held_out_excess_share) + chance


def predict(
    study: Study, solution: Solution, runs: Sequence[Run] | None = None, *, noise: Noise | None = None
) -> Prediction:
    """Predict runs with fitted parameters; only their initial states are fitted.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.
    runs
        Runs to predict; the held-out runs of the study where None.
    noise
        Noise model of the score; that of the solution where None.

    Returns
    -------
    Prediction
        Score, RMS and readings. Where the fitted runs leave the place of a discontinuity open, the score is that of the
        mixture over all places, and ``chi2`` and ``excess`` are the smallest; readings and RMS belong to the fitted
        place.
    """
    chosen = tuple(study.unseen if runs is None else runs)
    model = solution.noise if noise is None else noise
    if not chosen:
        return Prediction(score=0.0, rms=(), y=())
    found = [_at(study, solution, theta, chosen, model) for theta in places(solution, study.fitted, chosen)]
    scores = [p.score for p in found]
    # The mean of the densities: no place is more probable than another before the runs are seen.
    score = float(logsumexp(scores) - np.log(len(scores)))
    return replace(found[0], score=score, chi2=min(p.chi2 for p in found), excess=min(p.excess for p in found))


def _at(study: Study, solution: Solution, theta: Array, runs: Sequence[Run], model: Noise) -> Prediction:
    """Predict runs with the parameters ``theta``, shape (n_p,)."""
    held = {q.id: {"initial": float(p), "lower": float(p), "upper": float(p), "fixed": True}
            for q, p in zip(solution.equations.parameters, theta, strict=True)}  # fmt: skip
    simulator = study.factory(solution.equations.with_parameters(held))
    problem = under_noise(simulator, runs, model.but(scatters=()), theta, (), threads=study.threads)
    x = minimise(SumOfSquares.of(problem), np.zeros(problem.size), iterations=12).x
    x0 = problem.x0(x)
    # A scatter is linearised about a trajectory, so the initial states are first fitted without it.
    if model.scatters:
        problem = under_noise(simulator, runs, model, theta, x0, threads=study.threads)
        x = minimise(SumOfSquares.of(problem), with_starts(problem, np.zeros(problem.size), x0), iterations=12).x
        x0 = problem.x0(x)
    found = problem.blocks(x, jacobian=False)
    chi2 = float(found.residual @ found.residual)
    y = tuple(simulator.simulate(theta, run, x0=start).y for run, start in zip(runs, x0, strict=True))
    left = [(run.y - s)[run.scored] for run, s in zip(runs, y, strict=True)]
    rows = sum(scored_rows(run) for run in runs)
    # A model discrepancy can be mistaken for correlated noise; against the stated white noise it shows as excess.
    stated, excess = model.but(arma=Arma()), 0.0
    if study.noise_given and model == stated:
        excess = _excess(runs, found.rows)
    elif study.noise_given:
        problem_stated = under_noise(simulator, runs, stated, theta, x0, threads=study.threads)
        at = with_starts(problem_stated, np.zeros(problem_stated.size), x0)
        excess = _excess(runs, problem_stated.blocks(at, jacobian=False).rows)
    score = -0.5 * (chi2 + problem.log_determinant)
    return Prediction(score=score, rms=tuple(map(rms, left)), y=y, chi2=chi2, rows=rows, excess=excess)


def _excess(runs: Sequence[Run], whitened: Sequence[Array]) -> float:
    """Return the largest excess of a run's mean square over the stated noise, beyond chance."""
    powers = [float((r**2).sum()) / scored_rows(run) - 1.0 for r, run in zip(whitened, runs, strict=True)]
    chance = [THRESHOLDS.fit.largest_held_out_excess_in_std * np.sqrt(2.0 / scored_rows(run)) for run in runs]
    return max(0.0, *(float(p - c) for p, c in zip(powers, chance, strict=True)))
