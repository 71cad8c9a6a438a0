"""Whether one set of parameters holds in every run: a stand-in for something else needs others in each.

A score test after Chow (1960). At a fit of all runs together, those that no fit of the search saw among them, let
every parameter have a value of its own in each run: columns J_p·1_r of parameter p and run r. What the fit can move,
Q, is projected off. The residual's energy in the space that is left is χ² of its dimension under noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from discrepancy.chi_squared import log_tail
from discrepancy.noise_estimate import estimate
from discrepancy.refit import alike
from discrepancy.scan import movable, tangent_space
from discrepancy.solution import Solution, solve
from discrepancy.study import Study

OWN = 1e-4
"""Squared sine of the angle to what the fit can move below which a direction is none of a run's own."""


def constancy(study: Study, solution: Solution) -> tuple[float, int]:
    """Return p of a model's parameters being the same in all runs, and how many simulations of a run that took."""
    every = replace(study, fitted=(*study.fitted, *study.unseen), unseen=())
    if len(every.fitted) == 1:
        return 1.0, 0
    fit = solve(every, solution.effects, solution.noise, solution.values)
    calls = fit.calls
    if not alike(noise := estimate(every, fit), fit.noise, every.fitted[0].sensor_std):
        fit = solve(every, fit.effects, noise, fit.values, x0=fit.x0)
        calls += fit.calls
    return (_p(fit) if fit.finite else 0.0), calls * len(every.fitted)


def _p(fit: Solution) -> float:
    """Return p of the energy; columns as long as all readings are never laid out, only their products."""
    Q = tangent_space(fit)
    r = fit.residual - Q @ (Q.T @ fit.residual)
    places = np.flatnonzero(movable(fit))
    J = fit.blocks.jacobian[:, places[places < fit.problem.n_parameters]]
    products, held, along, first = [], [], [], 0
    for run in fit.problem.runs:
        rows = slice(first, first + run.y.size)
        size = np.linalg.norm(J[rows], axis=0)
        own = J[rows, size > 0.0] / size[size > 0.0]
        products.append(own.T @ own)
        held.append(Q[rows].T @ own)
        along.append(own.T @ r[rows])
        first += run.y.size
    H = np.concatenate(held, axis=1)
    values, vectors = np.linalg.eigh(block_diag(*products) - H.T @ H)
    kept = values > OWN
    if not kept.any():
        return 1.0
    energy = float(((vectors[:, kept].T @ np.concatenate(along)) ** 2 / values[kept]).sum())
    return float(np.exp(log_tail(energy, int(kept.sum()), fit.noise.colour.freedom)))
