"""Refit candidates: `Study`, current `Solution`, catalogue effect and its `Score` in, `Candidate` out.

1. Begin: add the effect at its best-scoring shape and fit everything for a few steps (`begin`).
2. Continue: fit on, and from the next best shape where it scores nearly as well (`continue_refit`).
3. Settle: fit to the end and estimate the noise in turn, until the noise no longer changes (`settle`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from haptid.discrepancy.candidate.candidate import Candidate, score_candidate
from haptid.discrepancy.candidate.starts import near, start_values
from haptid.discrepancy.detect.omnibus import omnibus
from haptid.discrepancy.detect.score_tests import Score
from haptid.discrepancy.fit.noise_estimate import PATHS, estimate
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.noise.correlation import Noise, Path, Scatter


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


def fit_briefly(
    study: Study, effects: Sequence[Effect], noise: Noise, values: Mapping[str, float], x0: Sequence[Array]
) -> Solution:
    """Fit for a few steps, at most `first_try_simulations` simulations of all runs.

    Parameters
    ----------
    study
        Study of the fit.
    effects
        Effects of the model in SI units.
    noise
        Noise model of the fit.
    values
        Start values of parameters by id.
    x0
        Start values of the initial states, one array a run.

    Returns
    -------
    Solution
        Preliminary fit; it need not have converged.
    """
    return solve(study, effects, noise, values, x0=x0, iterations=THRESHOLDS.candidate.first_try_simulations)


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
    solution = _fit_fully(study, effects, first.noise, first)
    solution, calls = sharpen_discontinuities(study, solution, calls + solution.calls)
    for k in range(THRESHOLDS.candidate.most_fits_under_new_noise):
        noise = estimate(study, solution, paths)
        if alike(noise, solution.noise, study.fitted[0].sensor_std):
            break
        again = _fit_fully(study, solution.effects, noise, solution)
        calls += again.calls
        if not again.finite:  # about the amplitudes of another scatter, the simulation may leave the numbers
            break
        solution = again
        # No noise model turns so large a residual into noise, so further estimates would cost fits in vain.
        if k >= 1 and omnibus(study, solution).far:
            break
    return score_candidate(study, solution, calls)


def _fit_fully(study: Study, effects: Sequence[Effect], noise: Noise, start: Solution) -> Solution:
    """Fit from where another fit ended, for at most `full_fit_simulations` simulations."""
    limit = THRESHOLDS.candidate.full_fit_simulations
    return solve(study, effects, noise, start.values, x0=start.x0, iterations=limit)


def sharpen_discontinuities(study: Study, solution: Solution, calls: int, edge: float = 0.0) -> tuple[Solution, int]:
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
    if a.arma.white != b.arma.white or len(a.scatters) != len(b.scatters):
        return False
    change = abs(a.arma.low_frequency_gain / b.arma.low_frequency_gain - 1.0)
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
    first = fit_briefly(study, effects, solution.noise, values, solution.x0)
    return settle(study, effects, first, first.calls)
