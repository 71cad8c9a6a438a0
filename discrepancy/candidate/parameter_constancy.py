"""Whether one set of parameters holds in every run: a stand-in for something else needs others in each.

A score test after Chow (1960). At a fit of all runs together, those that no fit of the search saw among them, let
every parameter have a value of its own in each run: columns J_p·1_r of parameter p and run r. What the fit can move,
Q, is projected off. The residual's energy in the space that is left is χ² of its dimension under noise.

Where a jump lies (a dead band) is no parameter of this kind: between two torques that were sent it changes nothing, and
beside torques that scatter one row more or less lies beyond it in every run. So every run may have its own.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from haptid.discrepancy.candidate.refit import alike
from haptid.discrepancy.detect.chi_squared import log_tail
from haptid.discrepancy.fit.noise_estimate import estimate
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.fit.tangent_space import movable, tangent_space
from haptid.discrepancy.study.study import Study
from haptid.measurement.values.run import Array

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
    Q = _with_own_places(fit, tangent_space(fit))
    r = fit.residual - Q @ (Q.T @ fit.residual)
    places = np.flatnonzero(movable(fit))
    J = fit.blocks.jacobian[:, places[places < fit.problem.n_parameters]]
    products, held, along = [], [], []
    for rows in _rows(fit):
        size = np.linalg.norm(J[rows], axis=0)
        own = J[rows, size > 0.0] / size[size > 0.0]
        products.append(own.T @ own)
        held.append(Q[rows].T @ own)
        along.append(own.T @ r[rows])
    H = np.concatenate(held, axis=1)
    values, vectors = np.linalg.eigh(block_diag(*products) - H.T @ H)
    kept = values > OWN
    if not kept.any():
        return 1.0
    energy = float(((vectors[:, kept].T @ np.concatenate(along)) ** 2 / values[kept]).sum())
    return float(np.exp(log_tail(energy, int(kept.sum()), fit.noise.colour.freedom)))


def _rows(fit: Solution) -> list[slice]:
    """Return the rows of every run's readings, one after another."""
    ends = np.cumsum([run.y.size for run in fit.problem.runs])
    return [slice(int(end) - run.y.size, int(end)) for end, run in zip(ends, fit.problem.runs, strict=True)]


def _with_own_places(fit: Solution, Q: Array) -> Array:
    """Return Q with what a place of its own for every jump in every run can move, orthonormal."""
    ids = fit.problem.scaling.ids
    jumps = [ids.index(effect.parameters[0].id) for effect in fit.effects if effect.threshold]
    if not jumps:
        return Q
    own = np.zeros((len(Q), len(jumps) * len(fit.problem.runs)))
    for k, rows in enumerate(_rows(fit)):
        own[rows, k * len(jumps) : (k + 1) * len(jumps)] = fit.blocks.jacobian[rows][:, jumps]
    own /= np.maximum(np.linalg.norm(own, axis=0), 1e-300)
    own -= Q @ (Q.T @ own)
    U, size, _ = np.linalg.svd(own, full_matrices=False)
    return np.column_stack((Q, U[:, size**2 > OWN]))
