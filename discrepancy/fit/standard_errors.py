"""Standard errors of a fit, also where the likelihood is rough: where contacts come and go, minimum lies by minimum.

About the minimum of a smooth ‖r‖² with covariance C, a move of one standard error along the valley of parameter k,
x̂ ± C·e_k/√C_kk, raises it by 1, straight on or once all else is fitted again. Where it does not (play, slack), fits
begin again from further out, and the 95 % interval is that of the likelihood over all minima found:
{θ : ℓ(θ) > max ℓ − χ²₁(0.95)/2} (Royall 1997, section 1.2), with a parabola about each whose standard errors are the
medians of all: a joint with contacts has many minima whatever the curvature of one says, and some are pits.
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
from haptid.identification.statistics.covariance import flat_information
from haptid.identification.statistics.profile_likelihood import fit_pinned
from haptid.measurement.values.run import Array
from haptid.support.processes.threads import map_threads

SMOOTH = (1 / 3, 3.0)
"""Rise of −2 ln L one standard error away within which the curvature is believed."""
SEEN = 0.5
"""Least rise that the data alone let expect: a parameter that they do not determine has no minimum to leave."""
OUT = (-6.0, -2.0, 2.0, 6.0)
"""Standard errors from the minimum at which fits begin again, along the valley of a parameter."""
AGAIN = 30
"""Most simulations of all runs in one of these fits."""
CLOSE = 0.1
"""Their tolerance in squares over the noise: little beside the `LEVEL` that makes the interval."""
LEVEL = float(chi2.ppf(0.95, 1))


def of_curvature(solution: Solution) -> Array:
    """Return the standard error of every parameter (n_p,), 0 where fixed, as the curvature at the minimum says."""
    return _physical(solution, covariance(solution))


def standard_errors(study: Study, solution: Solution, rounded: Solution | None = None) -> tuple[Solution, Array]:
    """Return the best minimum that is found, and there the standard error of every parameter (n_p,), 0 where fixed.

    Where the likelihood is rough, it is the distance to the farther end of the 95 % interval, over √χ²₁(0.95). Where
    bodies touch, ``rounded`` is the same fit with contacts that are rounded off more: its curvature says how far out
    fits begin again, and the least that the errors are. That at the bottom of a pit says nothing of the others.
    """
    touching = solution.touching
    about = rounded if touching and rounded is not None else solution
    C = covariance(about)
    least = _physical(about, C)
    valleys = {k: C[:, k] / np.sqrt(C[k, k]) for k in _of_effects(solution)}
    seen = {k: d for k, d in valleys.items() if np.linalg.norm(solution.blocks.jacobian @ d) ** 2 > SEEN}
    moves = [n * d for k, d in seen.items() if touching or rough(study, solution, k, d) for n in OUT]
    if not moves:
        return solution, least
    found = map_threads(partial(_again, replace(study, threads=1), solution), moves, threads=study.threads)
    minima = [m for m in (solution, *found) if m.finite]
    best = max(minima, key=lambda m: m.log_likelihood)
    std = np.maximum(np.median([of_curvature(m) for m in minima], axis=0), least)
    return best, np.maximum(std, _reach(best, minima, std))


def covariance(solution: Solution) -> Array:
    """Return the covariance (n, n) of the scaled unknowns, from whitened Jacobian and priors.

    Each parameter has the information of a uniform distribution between its bounds besides, 12/width²: of what the data
    say nothing (a stop that no run reaches), no more is known than that.
    """
    J = np.vstack((solution.blocks.jacobian, np.diag(np.sqrt(flat_information(solution.problem)))))
    size = np.linalg.norm(J, axis=0)
    inverse = solve_triangular(np.linalg.qr(J / size, mode="r"), np.eye(size.size))
    return np.asarray(inverse @ inverse.T / np.outer(size, size))


def rough(study: Study, solution: Solution, k: int, valley: Array) -> bool:
    """Whether −2 ln L one standard error of unknown ``k`` away is not what the curvature says, on a side within bounds.

    Where the straight ``valley`` (n,) says so, everything else is fitted again: a ridge that bends, as that of a wave's
    number, phase and amplitude does, is smooth all the same.
    """
    problem = solution.problem
    lower, upper = problem.scaling.bounds
    for x in (solution.x - valley, solution.x + valley):
        inside = x[: problem.n_parameters]
        if np.any((inside < lower) | (inside > upper)) or _as_curved(deviance(study, solution, x), solution):
            continue
        if not _as_curved(fit_pinned(problem, x, k)[1] + problem.log_determinant, solution):
            return True
    return False


def _as_curved(there: float, solution: Solution) -> bool:
    """Whether this −2 ln L is that of a parabola one standard error away."""
    return SMOOTH[0] < there + 2.0 * solution.log_likelihood < SMOOTH[1]


def _again(study: Study, solution: Solution, move: Array) -> Solution:
    """Fit from x̂ + ``move``."""
    problem, x = solution.problem, solution.x + move
    x[: problem.n_parameters] = np.clip(x[: problem.n_parameters], *problem.scaling.bounds)
    values = {q.id: float(p) for q, p in zip(solution.equations.parameters, problem.theta(x), strict=True)}
    return solve(study, solution.effects, solution.noise, values, x0=problem.x0(x), iterations=AGAIN, tolerance=CLOSE)


def _reach(solution: Solution, minima: Sequence[Solution], std: Array) -> Array:
    """Return how far the likelihood's interval over the minima reaches from the best one (n_p,), over √χ²₁(0.95)."""
    reach = np.zeros_like(std)
    for m in minima:
        room = 1.0 - 2.0 * (solution.log_likelihood - m.log_likelihood) / LEVEL
        if room > 0.0:
            reach = np.maximum(reach, np.abs(m.theta - solution.theta) / np.sqrt(LEVEL) + std * np.sqrt(room))
    return np.where(std > 0.0, reach, 0.0)


def _physical(solution: Solution, C: Array) -> Array:
    """Return the standard error of every parameter (n_p,) from the covariance of the scaled unknowns."""
    problem = solution.problem
    result = np.zeros(solution.theta.size)
    scaled = np.sqrt(np.diag(C))[: problem.n_parameters]
    result[list(problem.scaling.free)] = problem.scaling.slope(solution.theta) * scaled
    return result


def _of_effects(solution: Solution) -> list[int]:
    """Places of the effects' free parameters among the scaled unknowns."""
    ids = {q.id for e in solution.effects for q in e.parameters}
    return [k for k, id in enumerate(solution.problem.scaling.ids) if id in ids]
