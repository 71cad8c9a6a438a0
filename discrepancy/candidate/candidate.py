"""Score a refitted model: `Solution` in, `Candidate` with its criterion out, and whether its effects are needed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.fit.held_out import Prediction, predict
from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
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
    return count + len(solution.noise.scatters) + 2 * (not solution.noise.arma.white)


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
