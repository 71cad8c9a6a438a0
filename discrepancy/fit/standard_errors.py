"""Compute standard errors, also where contacts make the likelihood rough: `Solution` in, `Solution` and errors out.

1. Take the covariance C at the minimum. One standard error along the valley of parameter k, x̂ ± C·e_k/√C_kk, raises a
   smooth ‖r‖² by 1, straight on or after all other unknowns are fitted again.
2. For every effect parameter where it does not (play, slack), begin fits further out along that valley.
3. Take the 95 % interval of the likelihood over all minima, {θ : ℓ(θ) > max ℓ − χ²₁(0.95)/2}, with a parabola about
   each minimum. Its standard errors are the medians over all minima: a joint with contacts has many minima whatever the
   curvature of one of them says, and some are pits.

References
----------
Royall 1997, section 1.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import chi2

from haptid.discrepancy.fit.solution import Solution, deviance, solve
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.identification.statistics.covariance import flat_information
from haptid.identification.statistics.profile_likelihood import fit_pinned
from haptid.measurement.values.run import Array
from haptid.support.processes.threads import map_threads

DROP_AT_INTERVAL_END = float(chi2.ppf(THRESHOLDS.fit.interval_coverage, 1))
"""Drop of 2 ln L from its maximum to the ends of the 95 % interval, χ²₁(0.95)."""


def of_curvature(solution: Solution) -> Array:
    """Return the standard errors that the curvature at the minimum implies.

    Parameters
    ----------
    solution
        Fitted model.

    Returns
    -------
    ndarray
        Standard error of every parameter in its unit, shape (n_p,); 0 where the parameter is fixed.
    """
    return _physical(solution, covariance(solution))


def standard_errors(study: Study, solution: Solution, rounded: Solution | None = None) -> tuple[Solution, Array]:
    """Compute standard errors, and search for a better minimum where the likelihood is rough.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.
    rounded
        The same fit with contacts rounded off more. Where bodies touch, its curvature sets how far out fits begin again
        and the least standard errors, since the curvature at the bottom of a pit says nothing about the other minima.

    Returns
    -------
    solution, std
        Best minimum, and the standard error of every parameter in its unit, shape (n_p,), 0 where fixed. Where the
        likelihood is rough, the error is the distance to the farther end of the 95 % interval, over √χ²₁(0.95).
    """
    touching = solution.touching
    about = rounded if touching and rounded is not None else solution
    C = covariance(about)
    least = _physical(about, C)
    valleys = {k: C[:, k] / np.sqrt(C[k, k]) for k in _of_effects(solution)}
    moves: list[Array] = []
    for k, valley in valleys.items():
        rise = np.linalg.norm(solution.blocks.jacobian @ valley) ** 2
        seen = rise > THRESHOLDS.fit.least_predicted_rise_of_chi2
        if seen and (touching or rough(study, solution, k, valley)):
            moves += [n * valley for n in THRESHOLDS.fit.restarts_in_standard_errors]
    if not moves:
        return solution, least
    found = map_threads(partial(_again, replace(study, threads=1), solution), moves, threads=study.threads)
    minima = [m for m in (solution, *found) if m.finite]
    best = max(minima, key=lambda m: m.log_likelihood)
    std = np.maximum(np.median([of_curvature(m) for m in minima], axis=0), least)
    return best, np.maximum(std, _reach(best, minima, std))


def covariance(solution: Solution) -> Array:
    """Return the covariance of the scaled unknowns.

    Parameters
    ----------
    solution
        Fitted model.

    Returns
    -------
    ndarray
        Inverse of the information of whitened Jacobian, priors and bounds, shape (n, n).

    Notes
    -----
    Each parameter also has the information 12/width² of a uniform distribution between its bounds: where the data say
    nothing (a stop that no run reaches), its bounds are all that is known.
    """
    J = np.vstack((solution.blocks.jacobian, np.diag(np.sqrt(flat_information(solution.problem)))))
    # Columns of length 1, and QR instead of the Gram matrix, keep small information from being lost to rounding.
    size = np.linalg.norm(J, axis=0)
    inverse = solve_triangular(np.linalg.qr(J / size, mode="r"), np.eye(size.size))
    return np.asarray(inverse @ inverse.T / np.outer(size, size))


def rough(study: Study, solution: Solution, k: int, valley: Array) -> bool:
    """Say whether −2 ln L one standard error away contradicts the curvature, on a side within the bounds.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.
    k
        Index of the parameter among the scaled unknowns.
    valley
        Move of all unknowns by one standard error of this parameter, shape (n,).

    Returns
    -------
    bool
        True if −2 ln L rises too little or too much on either side.
    """
    problem = solution.problem
    lower, upper = problem.parametrisation.bounds
    for x in (solution.x - valley, solution.x + valley):
        inside = x[: problem.n_parameters]
        if np.any((inside < lower) | (inside > upper)) or _as_curved(deviance(study, solution, x), solution):
            continue
        # A ridge that bends, as that of a wave's number, phase and amplitude does, fails the straight test and is
        # smooth all the same. So all other unknowns are fitted again before the likelihood counts as rough.
        if not _as_curved(fit_pinned(problem, x, k)[1] + problem.log_determinant, solution):
            return True
    return False


def _as_curved(there: float, solution: Solution) -> bool:
    """Say whether this −2 ln L is that of a parabola one standard error away."""
    least, largest = THRESHOLDS.fit.trusted_rise_of_deviance
    return least < there + 2.0 * solution.log_likelihood < largest


def _again(study: Study, solution: Solution, move: Array) -> Solution:
    """Fit from x̂ + ``move``, clipped to the bounds."""
    problem, x = solution.problem, solution.x + move
    x[: problem.n_parameters] = np.clip(x[: problem.n_parameters], *problem.parametrisation.bounds)
    values = {q.id: float(p) for q, p in zip(solution.equations.parameters, problem.theta(x), strict=True)}
    return solve(
        study,
        solution.effects,
        solution.noise,
        values,
        x0=problem.x0(x),
        iterations=THRESHOLDS.fit.restart_simulations,
        tolerance=THRESHOLDS.fit.restart_tolerance_chi2,
    )


def _reach(solution: Solution, minima: Sequence[Solution], std: Array) -> Array:
    """Return the distance to the farther end of the likelihood interval, over √χ²₁(0.95), shape (n_p,)."""
    reach = np.zeros_like(std)
    for m in minima:
        room = 1.0 - 2.0 * (solution.log_likelihood - m.log_likelihood) / DROP_AT_INTERVAL_END
        # A minimum whose likelihood lies below the interval's level adds nothing; a parabola about one above it has
        # room for √room standard errors.
        if room > 0.0:
            distance = np.abs(m.theta - solution.theta) / np.sqrt(DROP_AT_INTERVAL_END)
            reach = np.maximum(reach, distance + std * np.sqrt(room))
    return np.where(std > 0.0, reach, 0.0)


def _physical(solution: Solution, C: Array) -> Array:
    """Return the standard error of every parameter (n_p,) from the covariance of the scaled unknowns."""
    problem = solution.problem
    result = np.zeros(solution.theta.size)
    scaled = np.sqrt(np.diag(C))[: problem.n_parameters]
    result[list(problem.parametrisation.free)] = problem.parametrisation.slope(solution.theta) * scaled
    return result


def _of_effects(solution: Solution) -> list[int]:
    """Places of the effects' free parameters among the scaled unknowns."""
    ids = {q.id for e in solution.effects for q in e.parameters}
    return [k for k, id in enumerate(solution.problem.parametrisation.ids) if id in ids]
