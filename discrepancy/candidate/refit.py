"""Refit of a candidate: base and effects together, from its best shapes, under a noise model of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.fit.held_out import Prediction, predict
from haptid.discrepancy.fit.noise_estimate import PATHS, estimate
from haptid.discrepancy.fit.solution import ROUGH, Solution, solve
from haptid.discrepancy.study.study import Study
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Noise, Path, Scatter
from haptid.support.linear_algebra import column_sizes, scaled_covariance, symmetric_inverse

FIRST, MORE, FULL = 6, 25, 60
"""Most simulations of all runs: of a first try, of what goes on with it, and of the fit to the end."""
SETTLING = 5
"""Most fits under a noise estimated anew: a first fit that has not arrived passes for noise that is not there."""
LARGE, SMALL, ALIKE = 10.0, 0.01, 0.5
"""Largest factor on an effect's typical size to start at, the same where it has no shape, and the share of T from which
another shape is tried too."""
LOST, LESS = 40.0, 0.1
"""Loss of log-likelihood by a first try that shows its amplitude to be too large, and the share to begin again at."""
EDGE, NEAR = 1e-3, 0.5
"""Relative distance from the lower bound at which a wave number or time constant counts as lying there, and the largest
one at which it does because two of its standard errors reach the bound."""
INFORMED = 0.5
"""A shape parameter counts as fitted where its std is below this share of its range (or of a factor e)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A model that was refitted and judged.

    Parameters
    ----------
    solution
        Its optimum, under its own noise model.
    prediction
        How it predicts the unseen runs.
    parameters
        Number of fitted parameters that the data inform, those of the noise included.
    bic
        Parameters·ln(rows) − 2·log-likelihood over the fitted runs.
    calls
        Simulations of all fitted runs.
    """

    solution: Solution
    prediction: Prediction
    parameters: int
    bic: float
    calls: int

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of its effects."""
        return self.solution.ids

    @property
    def criterion(self) -> float:
        """BIC of the fitted runs plus twice the negative predictive score of the unseen ones; smaller is better."""
        return self.bic - 2.0 * self.prediction.score


def score_candidate(study: Study, solution: Solution, calls: int) -> Candidate:
    """Score a solution on fitted and unseen runs."""
    k = count_informed_parameters(solution)
    return Candidate(
        solution=solution,
        prediction=predict(study, solution),
        parameters=k,
        bic=k * float(np.log(study.rows)) - 2.0 * solution.log_likelihood,
        calls=calls,
    )


def count_informed_parameters(solution: Solution) -> int:
    """Count the parameters of effects and noise that the data inform; those of the base are common to all models."""
    own = {q.id for e in solution.effects for q in e.parameters}
    amplitudes = {q.id for e in solution.effects for q in e.parameters[: e.amplitudes]}
    std = scaled_std(solution)
    lower, upper = solution.problem.scaling.bounds
    count = 0
    for i, id in enumerate(solution.problem.scaling.ids):
        if id in amplitudes:
            count += 1
        elif id in own:
            count += std[i] < INFORMED * min(1.0, float(upper[i] - lower[i]))
    return count + len(solution.noise.scatters) + 2 * (not solution.noise.colour.white)


def scaled_std(solution: Solution) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return standard deviations of the scaled free parameters; infinite where the data say nothing."""
    J = solution.blocks.jacobian
    size = column_sizes(J)
    values, vectors = np.linalg.eigh((J / size).T @ (J / size))
    inverse = (vectors**2) @ (1.0 / np.maximum(values, 1e-14))
    return np.asarray((np.sqrt(inverse) / size)[: solution.problem.n_parameters])


def start_values(effect: Effect, point: Point, amplitude: Sequence[float]) -> dict[str, float]:
    """Parameters of an effect at a scored shape, its amplitudes as the linear estimate says."""
    ids = [q.id for q in effect.parameters[: effect.amplitudes]]
    values = dict(point.values[0])
    if len(point.values) == 1 and effect.amplitudes > 1:
        return values
    for k, (id, factor) in enumerate(zip(ids, amplitude, strict=True)):
        values[id] = point.values[k][id] * factor
    return {q.id: min(max(values[q.id], q.lower), q.upper) for q in effect.parameters}


def starts_of(effect: Effect, score: Score) -> list[dict[str, float]]:
    """Where to begin an effect anew: as its score says, and at the largest amplitude of its grid where that holds one.

    What is not linear in its amplitude (a delay, a play, a compliance) may score nothing though it is large.
    """
    scored = start_values(effect, score.point, no_larger(score.amplitude, 1.0))
    amplitudes = [q.id for q in effect.parameters[: effect.amplitudes]]
    largest = {id: grid[-1] for id, grid in effect.shapes if id in amplitudes}
    if not largest:
        return [scored]
    return [*([scored] if score.T > 0.0 else []), scored | largest]


def begin(study: Study, current: Solution, effect: Effect, score: Score) -> Solution:
    """Add ``effect`` at its best shape and fit everything for a few steps: enough to rank it, not more.

    Where that leads away from the readings, it begins again at a tenth of the amplitude: the base may have gone where
    what its gap asks for, by a linear estimate, makes the joint stick and slip.
    """
    amplitude = np.array(near(effect, score.amplitude))
    begun = _start_refit(study, current, effect, score, amplitude)
    if begun.log_likelihood > current.log_likelihood - LOST:
        return begun
    again = _start_refit(study, current, effect, score, LESS * amplitude)
    return replace(likeliest(begun, again), calls=begun.calls + again.calls)


def likeliest(*fits: Solution) -> Solution:
    """Return the fit of the largest log-likelihood; one that has left the numbers comes last."""
    return max(fits, key=lambda s: s.log_likelihood if np.isfinite(s.log_likelihood) else -np.inf)


def _start_refit(study: Study, current: Solution, effect: Effect, score: Score, amplitude: Array) -> Solution:
    values = current.values | start_values(effect, score.point, amplitude.tolist())
    return _roughly(study, (*current.effects, effect), current.noise, values, current.x0, FIRST)


def continue_refit(study: Study, current: Solution, begun: Solution, score: Score) -> tuple[Solution, int]:
    """Go on with what was begun, and from the next best shape unlike it; return the better and the cost."""
    further = [_roughly(study, begun.effects, begun.noise, begun.values, begun.x0, MORE)]
    if score.others and score.others[0][1] > ALIKE * score.T:
        point, _, amplitude = score.others[-1]
        values = current.values | start_values(begun.effects[-1], point, near(begun.effects[-1], amplitude))
        further.append(_roughly(study, begun.effects, begun.noise, values, current.x0, MORE))
    best = likeliest(*further)
    return best, sum(s.calls for s in further)


def _roughly(
    study: Study,
    effects: Sequence[Effect],
    noise: Noise,
    values: Mapping[str, float],
    x0: Sequence[Array],
    iterations: int,
) -> Solution:
    """Fit not to the end."""
    return solve(study, effects, noise, values, x0=x0, iterations=iterations, tolerance=ROUGH)


def near(effect: Effect, amplitude: Sequence[float]) -> list[float]:
    """Scale a linear estimate down to where a fit may begin, the base being where it is.

    It says how large the effect is once the base has moved along; with the base where it is, a large effect is far
    from the readings. What has amplitudes alone is brought there, base and all, by the first step of the fit; a shape
    rests where the amplitude is small.
    """
    free = sum(not x.fixed for x in effect.parameters)
    return no_larger(amplitude, SMALL if free == effect.amplitudes and not effect.shapes else LARGE)


def no_larger(amplitude: Sequence[float], largest: float) -> list[float]:
    """Scale a linear estimate down to ``largest`` times the typical size."""
    factor = min(1.0, largest / max(*map(abs, amplitude), 1e-300))
    return [a * factor for a in amplitude]


def settle(
    study: Study, effects: Sequence[Effect], first: Solution, calls: int = 0, paths: Sequence[Path] = PATHS
) -> Candidate:
    """Fit to the end, with the noise model estimated from the fit's own residuals until it rests."""
    solution = solve(study, effects, first.noise, first.values, x0=first.x0, iterations=FULL)
    solution, calls = sharpen_jumps(study, solution, calls + solution.calls)
    for k in range(SETTLING):
        noise = estimate(study, solution, paths)
        if alike(noise, solution.noise, study.fitted[0].sensor_std):
            break
        again = solve(study, solution.effects, noise, solution.values, x0=solution.x0, iterations=FULL)
        calls += again.calls
        if not again.finite:  # about the amplitudes of another scatter, the simulation may leave the numbers
            break
        solution = again
        if k >= 1 and omnibus(study, solution).far:
            break
    return score_candidate(study, solution, calls)


def sharpen_jumps(study: Study, solution: Solution, calls: int, edge: float = 0.0) -> tuple[Solution, int]:
    """Make jumps that are rounded off sharper, step by step, as long as that is more likely; return the cost too.

    None is made sharper than ``edge``.
    """
    while any(sharper := [e.sharper if e.edges and e.edges[0] >= edge else None for e in solution.effects]):
        effects = [new or effect for new, effect in zip(sharper, solution.effects, strict=True)]
        values = {id: p for id, p in solution.values.items() if id not in {effect.edge for effect in effects}}
        tried = solve(study, effects, solution.noise, values, x0=solution.x0, iterations=FULL)
        calls += tried.calls
        if tried.log_likelihood <= solution.log_likelihood:
            break
        solution = tried
    return solution, calls


def significance(solution: Solution) -> tuple[float, bool]:
    """Return the least Wald statistic of the earlier effects' amplitudes, and whether one of all ended at its bound.

    For the last effect, its gain speaks: a Wald statistic is as wrong as the curvature where spring, weight and a bent
    spring trade off, and the place of a jump changes nothing between two torques.

    A wave number or a time constant at the lower end of its range, or one that cannot be told from it, counts as at its
    bound: there it stands for something else (a wave longer than the travel for a bent spring). So does a first
    amplitude, 0 its lower bound, that does not earn what BIC charges for it, ln n, while other parameters carry the
    effect: a slack of nothing in an elastic tendon, a compliance of 0.3 ± 2 whose pole makes a delay of a lag.
    """
    ids = solution.problem.scaling.ids
    J = solution.blocks.jacobian
    covariance, size = scaled_covariance(J)
    zero = solution.problem.scaling.scaled(np.zeros(solution.theta.size))
    lower, upper = solution.problem.scaling.bounds
    wald, at_bound = np.inf, False
    for effect in solution.effects:
        at = [ids.index(q.id) for q in effect.parameters[: effect.amplitudes]]
        a = (solution.x[at] - zero[at]) * size[at]
        if effect is not solution.effects[-1] and not effect.threshold:
            wald = min(wald, float(a @ symmetric_inverse(covariance[np.ix_(at, at)]) @ a))
        one_sided = lower[at[0]] >= zero[at[0]]
        told = effect.threshold or a[0] ** 2 > np.log(len(J)) * covariance[at[0], at[0]]
        at_bound |= bool(one_sided and not told)
        room = 1e-4 * (upper[at] - lower[at])
        low = (solution.x[at] - lower[at] < room) & (lower[at] < zero[at] - room)
        at_bound |= bool(np.any((upper[at] - solution.x[at] < room) | low))
        shape = [ids.index(q.id) for q in effect.parameters[effect.amplitudes :] if q.scale == "log" and not q.fixed]
        error = np.sqrt(np.diag(covariance)[shape]) / size[shape]
        at_bound |= bool(np.any(solution.x[shape] - lower[shape] < np.clip(2.0 * error, EDGE, NEAR)))
    return wald, at_bound


def alike(a: Noise, b: Noise, std: Array) -> bool:
    """Whether two noise models are the same for all that a fit can tell, the sensors' noise being ``std``."""
    if a.colour.white != b.colour.white or len(a.scatters) != len(b.scatters):
        return False
    near = abs(a.colour.low_frequency_gain / b.colour.low_frequency_gain - 1.0) < 0.05
    return near and all(_as_large(x, y, std) for x, y in zip(a.scatters, b.scatters, strict=True))


def _as_large(a: Scatter, b: Scatter, std: Array) -> bool:
    """Whether two scatters are of the same joint on the same path, and as large."""
    same = (a.column, a.path) == (b.column, b.path)
    centred = abs(a.centre - b.centre) * a.size <= 0.1 * float(std[a.column])
    return same and centred and abs(a.size - b.size) <= 0.1 * max(a.size, b.size)


def refit_with(study: Study, solution: Solution, effects: Sequence[Effect], values: Mapping[str, float]) -> Candidate:
    """Fit a model with ``effects`` from ``values``: backward steps and the re-based base use it."""
    first = solve(study, effects, solution.noise, values, x0=solution.x0, iterations=FIRST)
    return settle(study, effects, first, first.calls)
