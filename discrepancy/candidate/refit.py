"""Refit candidates: `Study`, current `Solution`, catalogue effect and its `Score` in, `Candidate` out.

1. Begin: add the effect at its best-scoring shape and fit everything for a few steps (`begin`).
2. Continue: fit on, and from the next best shape where it scores nearly as well (`continue_refit`).
3. Settle: fit to the end and estimate the noise in turn, until the noise no longer changes (`settle`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.fit.held_out import Prediction, predict
from haptid.discrepancy.fit.noise_estimate import PATHS, estimate
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Noise, Path, Scatter
from haptid.support.linear_algebra import inverse, scaled_covariance, symmetric_inverse


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A refitted model with its scores.

    Parameters
    ----------
    solution
        Optimum under the model's own noise.
    prediction
        Prediction of the held-out runs.
    parameters
        Number of fitted parameters that the data inform, those of the noise included and those of the nominal model
        not.
    bic
        parameters·ln(rows) − 2·log-likelihood over the fitted runs.
    calls
        Number of simulations of all fitted runs.
    """

    solution: Solution
    prediction: Prediction
    parameters: int
    bic: float
    calls: int

    @property
    def ids(self) -> tuple[str, ...]:
        """Ids of the effects."""
        return self.solution.ids

    @property
    def criterion(self) -> float:
        """BIC of the fitted runs minus twice the log predictive score of the held-out runs; smaller is better."""
        return self.bic - 2.0 * self.prediction.score


def score_candidate(study: Study, solution: Solution, calls: int) -> Candidate:
    """Score a solution on fitted and held-out runs.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.
    calls
        Number of simulations of all fitted runs that it took.

    Returns
    -------
    Candidate
        The solution with its BIC, and with its prediction of the held-out runs.
    """
    k = count_informed_parameters(solution)
    return Candidate(
        solution=solution,
        prediction=predict(study, solution),
        parameters=k,
        bic=k * float(np.log(study.rows)) - 2.0 * solution.log_likelihood,
        calls=calls,
    )


def count_informed_parameters(solution: Solution) -> int:
    """Count the informed parameters of effects and noise; those of the nominal model are common to all candidates.

    Parameters
    ----------
    solution
        Fitted model.

    Returns
    -------
    int
        Number of amplitudes, of shape parameters that the data inform, of scatters, and 2 for correlated noise.
    """
    own = {q.id for e in solution.effects for q in e.parameters}
    amplitudes = {q.id for e in solution.effects for q in e.parameters[: e.amplitudes]}
    J = solution.blocks.jacobian
    std = np.sqrt(np.diag(inverse(J.T @ J)))  # very large where the data say nothing
    lower, upper = solution.problem.parametrisation.bounds
    count = 0
    for i, id in enumerate(solution.problem.parametrisation.ids):
        # An amplitude always counts. A shape that the data leave open adds no freedom to the fit, so BIC must not
        # charge for it.
        if id in amplitudes:
            count += 1
        elif id in own:
            count += std[i] < THRESHOLDS.candidate.informed_std_over_range * min(1.0, float(upper[i] - lower[i]))
    return count + len(solution.noise.scatters) + 2 * (not solution.noise.colour.white)


def start_values(effect: Effect, point: Point, amplitude: Sequence[float]) -> dict[str, float]:
    """Return start values of an effect at a scored shape.

    Parameters
    ----------
    effect
        Effect in SI units.
    point
        Shape of the effect.
    amplitude
        Linear estimate of the factor on each column's amplitude.

    Returns
    -------
    dict
        Parameters by id, within their bounds.
    """
    ids = [q.id for q in effect.parameters[: effect.amplitudes]]
    values = dict(point.values[0])
    # One column for several amplitudes means that the grid itself holds the amplitudes.
    if len(point.values) == 1 and effect.amplitudes > 1:
        return values
    for k, (id, factor) in enumerate(zip(ids, amplitude, strict=True)):
        values[id] = point.values[k][id] * factor
    return {q.id: min(max(values[q.id], q.lower), q.upper) for q in effect.parameters}


def starts_of(effect: Effect, score: Score) -> list[dict[str, float]]:
    """Return the start values from which a catalogue effect is fitted through homotopy.

    Effects that are not linear in their amplitude (a delay, a play, a compliance) may have a score of 0 though they are
    large, so the fit also begins at the largest amplitude of their grid.

    Parameters
    ----------
    effect
        Effect in SI units.
    score
        Best score of the effect.

    Returns
    -------
    list of dict
        One or two sets of parameters by id.
    """
    scored = start_values(effect, score.point, no_larger(score.amplitude, 1.0))
    amplitudes = [q.id for q in effect.parameters[: effect.amplitudes]]
    largest = {id: grid[-1] for id, grid in effect.shapes if id in amplitudes}
    if not largest:
        return [scored]
    return [*([scored] if score.T > 0.0 else []), scored | largest]


def begin(study: Study, current: Solution, effect: Effect, score: Score) -> Solution:
    """Add an effect at its best shape and fit everything for a few steps: enough to rank the effect.

    Parameters
    ----------
    study
        Study of the fit.
    current
        Model that the effect extends.
    effect
        Effect in SI units.
    score
        Best score of the effect on the residual of ``current``.

    Returns
    -------
    Solution
        Preliminary fit, not converged.
    """
    amplitude = np.array(near(effect, score.amplitude))
    begun = _start_refit(study, current, effect, score, amplitude)
    if begun.log_likelihood > current.log_likelihood - THRESHOLDS.candidate.largest_first_try_loss:
        return begun
    # The nominal model may have moved to where the linear estimate of the amplitude makes the joint stick and slip.
    # From a tenth of that amplitude the fit can find its way.
    again = _start_refit(study, current, effect, score, THRESHOLDS.candidate.amplitude_share_after_loss * amplitude)
    return replace(likeliest(begun, again), calls=begun.calls + again.calls)


def likeliest(*fits: Solution) -> Solution:
    """Choose the fit of largest log-likelihood.

    Parameters
    ----------
    *fits
        Fits to the same runs, at least one.

    Returns
    -------
    Solution
        The first of the largest; a fit whose log-likelihood is not finite only where all are such.
    """
    return max(fits, key=lambda s: s.log_likelihood if np.isfinite(s.log_likelihood) else -np.inf)


def _start_refit(study: Study, current: Solution, effect: Effect, score: Score, amplitude: Array) -> Solution:
    values = current.values | start_values(effect, score.point, amplitude.tolist())
    return _roughly(
        study, (*current.effects, effect), current.noise, values, current.x0, THRESHOLDS.candidate.first_try_simulations
    )


def continue_refit(study: Study, current: Solution, begun: Solution, score: Score) -> tuple[Solution, int]:
    """Continue a preliminary fit, and fit from the next best shape where it scores nearly as well.

    Parameters
    ----------
    study
        Study of the fit.
    current
        Model that the effect extends.
    begun
        Preliminary fit of `begin`.
    score
        Best score of the effect, with its next best shapes.

    Returns
    -------
    solution, calls
        The likelier fit, and the number of simulations of all runs.
    """
    further = [
        _roughly(study, begun.effects, begun.noise, begun.values, begun.x0, THRESHOLDS.candidate.continued_simulations)
    ]
    if score.others and score.others[0][1] > THRESHOLDS.candidate.least_second_shape_share * score.T:
        point, _, amplitude = score.others[-1]
        values = current.values | start_values(begun.effects[-1], point, near(begun.effects[-1], amplitude))
        further.append(
            _roughly(study, begun.effects, begun.noise, values, current.x0, THRESHOLDS.candidate.continued_simulations)
        )
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
    """Fit for at most ``iterations`` simulations, to the tolerance `rough_tolerance_chi2`."""
    return solve(
        study, effects, noise, values, x0=x0, iterations=iterations, tolerance=THRESHOLDS.fit.rough_tolerance_chi2
    )


def near(effect: Effect, amplitude: Sequence[float]) -> list[float]:
    """Scale a linear estimate of the amplitudes down to where a fit may begin.

    The linear estimate gives the size of the effect once the nominal model has moved along. With the nominal model
    where it is, a large effect is far from the readings. An effect with amplitudes alone reaches its size in the first
    step of the fit, together with the nominal model, and so begins small. A shape parameter does not move where the
    amplitude is small.

    Parameters
    ----------
    effect
        Effect in SI units.
    amplitude
        Factors on the effect's typical size.

    Returns
    -------
    list of float
        Factors of the same ratio, at most `largest_start_size_without_shape` without shape parameters and
        `largest_start_size` with them.
    """
    free = sum(not x.fixed for x in effect.parameters)
    if free == effect.amplitudes and not effect.shapes:
        return no_larger(amplitude, THRESHOLDS.candidate.largest_start_size_without_shape)
    return no_larger(amplitude, THRESHOLDS.candidate.largest_start_size)


def no_larger(amplitude: Sequence[float], largest: float) -> list[float]:
    """Scale factors down in common until none exceeds a limit.

    Parameters
    ----------
    amplitude
        Factors on the effect's typical size.
    largest
        Largest magnitude of a factor.

    Returns
    -------
    list of float
        Factors of the same ratio.
    """
    factor = min(1.0, largest / max(*map(abs, amplitude), 1e-300))
    return [a * factor for a in amplitude]


def settle(
    study: Study, effects: Sequence[Effect], first: Solution, calls: int = 0, paths: Sequence[Path] = PATHS
) -> Candidate:
    """Fit to the end, and estimate the noise from the residuals in turn until it no longer changes.

    Parameters
    ----------
    study
        Study of the fit.
    effects
        Effects in SI units.
    first
        Preliminary fit; its parameters, initial states and noise are the start.
    calls
        Simulations of all runs that the preliminary fit took.
    paths
        Paths on which amplitudes may scatter.

    Returns
    -------
    Candidate
        Refitted model under its own noise, with its scores.
    """
    solution = solve(
        study, effects, first.noise, first.values, x0=first.x0, iterations=THRESHOLDS.candidate.full_fit_simulations
    )
    solution, calls = sharpen_jumps(study, solution, calls + solution.calls)
    for k in range(THRESHOLDS.candidate.most_fits_under_new_noise):
        noise = estimate(study, solution, paths)
        if alike(noise, solution.noise, study.fitted[0].sensor_std):
            break
        again = solve(
            study,
            solution.effects,
            noise,
            solution.values,
            x0=solution.x0,
            iterations=THRESHOLDS.candidate.full_fit_simulations,
        )
        calls += again.calls
        if not again.finite:  # about the amplitudes of another scatter, the simulation may leave the numbers
            break
        solution = again
        # No noise model turns so large a residual into noise, so further estimates would cost fits in vain.
        if k >= 1 and omnibus(study, solution).far:
            break
    return score_candidate(study, solution, calls)


def sharpen_jumps(study: Study, solution: Solution, calls: int, edge: float = 0.0) -> tuple[Solution, int]:
    """Sharpen rounded discontinuities step by step, as long as the likelihood grows.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.
    calls
        Simulations of all runs so far.
    edge
        Rounding, as a share of the threshold, below which none is sharpened.

    Returns
    -------
    solution, calls
        Likeliest fit, and the simulations so far with those of this function.
    """
    while any(sharper := [e.sharper if e.edges and e.edges[0] >= edge else None for e in solution.effects]):
        effects = [new or effect for new, effect in zip(sharper, solution.effects, strict=True)]
        values = {id: p for id, p in solution.values.items() if id not in {effect.edge for effect in effects}}
        tried = solve(
            study, effects, solution.noise, values, x0=solution.x0, iterations=THRESHOLDS.candidate.full_fit_simulations
        )
        calls += tried.calls
        if tried.log_likelihood <= solution.log_likelihood:
            break
        solution = tried
    return solution, calls


def significance(solution: Solution) -> tuple[float, bool]:
    """Return the least Wald statistic of the earlier effects, and whether a parameter of any effect ended at its bound.

    Parameters
    ----------
    solution
        Fitted model.

    Returns
    -------
    wald, at_bound
        Least aᵀC⁻¹a over the amplitudes a of each effect but the last and those with a discontinuity in the torque,
        infinite where there is none; and whether an amplitude or a shape of logarithmic scale lies at its bound.

    Notes
    -----
    The last effect is judged by its gain. A Wald statistic is as wrong as the curvature where spring, weight and a bent
    spring trade off, and the place of a discontinuity changes nothing between two torques.

    A wave number or time constant at the lower end of its range, or not distinguishable from it, counts as at its
    bound: there it stands for another effect (a wave longer than the travel for a bent spring). So does a first
    amplitude with lower bound 0 whose squared ratio to its standard error is below the ln n that BIC charges for it,
    while other parameters carry the effect: an elastic tendon without slack, a compliance of 0.3 ± 2 whose pole makes a
    delay of a lag.
    """
    ids = solution.problem.parametrisation.ids
    J = solution.blocks.jacobian
    covariance, size = scaled_covariance(J)
    zero = solution.problem.parametrisation.to_coordinates(np.zeros(solution.theta.size))
    lower, upper = solution.problem.parametrisation.bounds
    wald, at_bound = np.inf, False
    for effect in solution.effects:
        at = [ids.index(q.id) for q in effect.parameters[: effect.amplitudes]]
        a = (solution.x[at] - zero[at]) * size[at]
        # A Wald statistic would judge the last effect by the curvature; its gain over the model before it is the better
        # evidence.
        if effect is not solution.effects[-1] and not effect.threshold:
            wald = min(wald, float(a @ symmetric_inverse(covariance[np.ix_(at, at)]) @ a))
        one_sided = lower[at[0]] >= zero[at[0]]
        told = effect.threshold or a[0] ** 2 > np.log(len(J)) * covariance[at[0], at[0]]
        at_bound |= bool(one_sided and not told)
        room = 1e-4 * (upper[at] - lower[at])
        # A lower bound at zero amplitude is judged by its standard error above; only a bound below zero is an end of
        # the range.
        low = (solution.x[at] - lower[at] < room) & (lower[at] < zero[at] - room)
        at_bound |= bool(np.any((upper[at] - solution.x[at] < room) | low))
        # The margin is twice the standard error, so that a poorly known shape counts as at its bound, but at most
        # `largest_margin_at_bound`, so that an undetermined one does not always.
        shape = [ids.index(q.id) for q in effect.parameters[effect.amplitudes :] if q.scale == "log" and not q.fixed]
        error = np.sqrt(np.diag(covariance)[shape]) / size[shape]
        least, largest = THRESHOLDS.candidate.least_margin_at_bound, THRESHOLDS.candidate.largest_margin_at_bound
        at_bound |= bool(np.any(solution.x[shape] - lower[shape] < np.clip(2.0 * error, least, largest)))
    return wald, at_bound


def alike(a: Noise, b: Noise, std: Array) -> bool:
    """Say whether two noise models are equal within what changes a fit.

    Parameters
    ----------
    a, b
        Noise models.
    std
        Standard deviation of each sensor [rad], shape (n_joints,).

    Returns
    -------
    bool
        True if both have the same terms, low-frequency gains within `settled_gain_change`, and scatters as in
        `_as_large`.
    """
    if a.colour.white != b.colour.white or len(a.scatters) != len(b.scatters):
        return False
    change = abs(a.colour.low_frequency_gain / b.colour.low_frequency_gain - 1.0)
    near = change < THRESHOLDS.candidate.settled_gain_change
    return near and all(_as_large(x, y, std) for x, y in zip(a.scatters, b.scatters, strict=True))


def _as_large(a: Scatter, b: Scatter, std: Array) -> bool:
    """Say whether two scatters are equal within what changes a fit.

    They act on the same joint and path. Their sizes differ by at most the share `settled_scatter_change`, and the shift
    of the centre changes the reading by at most that share of the sensor noise.
    """
    share = THRESHOLDS.candidate.settled_scatter_change
    same = (a.column, a.path) == (b.column, b.path)
    centred = abs(a.centre - b.centre) * a.size <= share * float(std[a.column])
    return same and centred and abs(a.size - b.size) <= share * max(a.size, b.size)


def refit_with(study: Study, solution: Solution, effects: Sequence[Effect], values: Mapping[str, float]) -> Candidate:
    """Refit a model with ``effects`` from ``values``, as backward elimination does.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fit whose noise and initial states are the start.
    effects
        Effects of the model in SI units.
    values
        Start values of parameters by id.

    Returns
    -------
    Candidate
        Model fitted to the end, with its scores.
    """
    first = solve(
        study, effects, solution.noise, values, x0=solution.x0, iterations=THRESHOLDS.candidate.first_try_simulations
    )
    return settle(study, effects, first, first.calls)
