"""Candidates refitted jointly with all parameters, and judged by what they gain on fitted and on unseen runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discrepancy.held_out import Prediction, predict
from discrepancy.noise import Noise, Path
from discrepancy.scan import Score, tangent_space
from discrepancy.scatter import best_scatter, cycle_columns, restricted_likelihood
from discrepancy.solution import Solution, solve
from discrepancy.study import Study
from model.effect import Effect

SCATTER = "amplitude_scatter"
PATHS: tuple[Path, ...] = ("reading", "torque")


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A model that adds something to another.

    Parameters
    ----------
    key
        What it adds.
    solution, prediction
        Its joint fit, and how that predicts the unseen runs.
    evidence
        Twice the gain in held-out log predictive score over the model without it.
    bic
        Gain in the Bayesian information criterion, 2·Δ ln L − k·ln n; positive speaks for it.
    """

    key: str
    solution: Solution
    prediction: Prediction
    evidence: float
    bic: float

    @property
    def id(self) -> str:
        """The entry's id, without its variant."""
        return self.key.partition(":")[0]


def candidate(study: Study, key: str, richer: Solution, before: Solution, unseen: Prediction, extra: int) -> Candidate:
    """Judge ``richer`` against ``before``, whose prediction is ``unseen``, for ``extra`` more parameters."""
    prediction = predict(study, richer)
    gain = 2.0 * (richer.log_likelihood - before.log_likelihood)
    return Candidate(
        key=key,
        solution=richer,
        prediction=prediction,
        evidence=2.0 * (prediction.score - unseen.score),
        bic=gain - extra * float(np.log(max(study.rows, 2))),
    )


def refit(
    study: Study, before: Solution, unseen: Prediction, effect: Effect, score: Score, tries: int = 2
) -> Candidate:
    """Add ``effect`` (SI units) and refit everything, from the ``tries`` best shapes of its scan; the best counts."""
    starts = [(score.point, score.amplitude), *((point, amplitude) for point, _, amplitude in score.others)]
    fits = []
    for point, amplitude in starts[:tries]:
        values = dict(before.values) | {x.id: x.initial for x in effect.parameters}
        single = len(point.values) == 1 and effect.amplitudes > 1
        for column, factor in zip(point.values, amplitude, strict=True):
            values |= {k: v for k, v in column.items() if k not in _amplitudes(effect)}
            for id in _amplitudes(effect):
                if column.get(id, 0.0) != 0.0:
                    values[id] = column[id] * (1.0 if single else factor)
        fits.append(solve(study, (*before.effects, effect), before.noise, values, x0=before.x0))
    best = max(fits, key=lambda found: found.log_likelihood)
    return candidate(study, effect.key, best, before, unseen, len(effect.parameters))


def _amplitudes(effect: Effect) -> tuple[str, ...]:
    return tuple(x.id for x in effect.parameters[: effect.amplitudes])


def scattered(study: Study, before: Solution, unseen: Prediction, centre: float) -> Candidate | None:
    """Add a scatter of the cycles' amplitudes, on the reading or on the torque, whichever explains more."""
    if before.noise.scatter > 0:
        return None
    fits = []
    for path in PATHS:
        noise = Noise(colour=before.noise.colour, path=path, centre=centre)
        s, gain = _scatter(study, before, noise)
        if s > 0 and gain > np.log(study.rows):
            fits.append(solve(study, before.effects, noise.but(scatter=s), before.values, x0=before.x0))
    if not fits:
        return None
    best = max(fits, key=lambda found: found.log_likelihood)
    return candidate(study, SCATTER, best, before, unseen, 1)


def _scatter(study: Study, before: Solution, noise: Noise) -> tuple[float, float]:
    """Restricted-likelihood estimate of s from the residual, off what the parameters can move."""
    simulator = study.factory(before.equations)
    columns = [
        whiten.colour.whiten(cycle_columns(simulator, run, noise, before.theta, x0))
        for run, x0, whiten in zip(study.fitted, before.x0, before.problem.whiteners, strict=True)
    ]
    n = before.residual.size
    M = np.zeros((n, sum(c.shape[1] for c in columns)))
    row = column = 0
    for block in columns:
        M[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    Q = tangent_space(before)
    M -= Q @ (Q.T @ M)
    r = before.residual - Q @ (Q.T @ before.residual)
    d2, c2 = restricted_likelihood(r, M)
    return best_scatter(d2, c2)


def without(study: Study, full: Solution, drop: str) -> Solution:
    """Refit ``full`` without the effect whose key is ``drop``, from the same optimum."""
    noise = full.noise.but(scatter=0.0) if drop == SCATTER else full.noise
    kept: Sequence[Effect] = tuple(e for e in full.effects if e.key != drop)
    return solve(study, kept, noise, full.values, x0=full.x0)
