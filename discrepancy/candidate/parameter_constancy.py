"""Test whether one parameter set holds in every run: `Study` and `Solution` in, p-value out.

A surrogate for another effect needs other parameters in each run.

1. Fit all runs together, held-out ones included.
2. Let every parameter have a value of its own in each run: columns J_p·1_r of parameter p and run r.
3. Project these columns off the tangent space Q of the fit.
4. The residual's energy in the remaining space is χ² under noise, with as many degrees of freedom as it has dimensions.
5. The parameter whose own columns alone have the least p-value is the one that differs most.

The place of a discontinuity (a dead band) is no parameter of this kind: between two torques that were sent it changes
nothing, and beside torques that scatter, one row more or less lies beyond it in every run. So every run may have its
own place.

References
----------
Chow 1960, of which this is the score-test form.
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
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def constancy(study: Study, solution: Solution) -> tuple[float, str, int]:
    """Test whether the parameters of a model are the same in all runs.

    Parameters
    ----------
    study
        Study of the fit.
    solution
        Fitted model.

    Returns
    -------
    p, id, simulations
        p-value (1 for a single run, 0 where the fit of all runs fails), id of the parameter that differs most between
        the runs (empty where there is none to tell), and the number of simulated runs.
    """
    every = replace(study, fitted=(*study.fitted, *study.unseen), unseen=())
    if len(every.fitted) == 1:
        return 1.0, "", 0
    fit = solve(every, solution.effects, solution.noise, solution.values)
    calls = fit.calls
    # Held-out runs may change the noise estimate, and the test is valid only under the noise of the runs that it
    # judges.
    if not alike(noise := estimate(every, fit), fit.noise, every.fitted[0].sensor_std):
        fit = solve(every, fit.effects, noise, fit.values, x0=fit.x0)
        calls += fit.calls
    p, id = _test_runs(fit) if fit.finite else (0.0, "")
    return p, id, calls * len(every.fitted)


def _test_runs(fit: Solution) -> tuple[float, str]:
    """Return p of the residual's energy in the space of run-specific parameters, and the parameter of the least p."""
    Q = _with_own_places(fit, tangent_space(fit))
    # The columns of all runs would be n_r × (n_p·n_runs) numbers, most of them 0. Their products with one another, with
    # Q and with r are enough: H = QᵀD, and the Gram matrix of the projected columns is DᵀD − HᵀH.
    r = fit.residual - Q @ (Q.T @ fit.residual)
    places = np.flatnonzero(movable(fit))
    places = places[places < fit.problem.n_parameters]
    J = fit.blocks.jacobian[:, places]
    products, held, along, owners = [], [], [], []
    for rows in _rows(fit):
        size = np.linalg.norm(J[rows], axis=0)
        own = J[rows, size > 0.0] / size[size > 0.0]
        products.append(own.T @ own)
        held.append(Q[rows].T @ own)
        along.append(own.T @ r[rows])
        owners.append(places[size > 0.0])
    H = np.concatenate(held, axis=1)
    gram, score, owner = block_diag(*products) - H.T @ H, np.concatenate(along), np.concatenate(owners)
    freedom = fit.noise.arma.freedom
    least = {k: _log_p(gram[np.ix_(owner == k, owner == k)], score[owner == k], freedom) for k in places}
    differs = min(places, key=lambda k: least[k], default=None)
    id = "" if differs is None else fit.problem.parametrisation.ids[differs]
    return float(np.exp(_log_p(gram, score, freedom))), id


def _log_p(gram: Array, score: Array, freedom: float) -> float:
    """Return ln p of the residual's energy in the span of columns with this Gram matrix and these products with it."""
    values, vectors = np.linalg.eigh(gram)
    kept = values > THRESHOLDS.candidate.least_own_squared_sine
    energy = float(((vectors[:, kept].T @ score) ** 2 / values[kept]).sum())
    return log_tail(energy, int(kept.sum()), freedom) if kept.any() else 0.0


def _rows(fit: Solution) -> list[slice]:
    """Return the slice of every run's residuals in the stacked residual vector."""
    ends = np.cumsum([run.y.size for run in fit.problem.runs])
    return [slice(int(end) - run.y.size, int(end)) for end, run in zip(ends, fit.problem.runs, strict=True)]


def _with_own_places(fit: Solution, Q: Array) -> Array:
    """Extend Q by the directions of a run-specific place for every discontinuity; return an orthonormal basis."""
    ids = fit.problem.parametrisation.ids
    jumps = [ids.index(effect.parameters[0].id) for effect in fit.effects if effect.threshold]
    if not jumps:
        return Q
    own = np.zeros((len(Q), len(jumps) * len(fit.problem.runs)))
    for k, rows in enumerate(_rows(fit)):
        own[rows, k * len(jumps) : (k + 1) * len(jumps)] = fit.blocks.jacobian[rows][:, jumps]
    own /= np.maximum(np.linalg.norm(own, axis=0), 1e-300)
    own -= Q @ (Q.T @ own)
    U, size, _ = np.linalg.svd(own, full_matrices=False)
    return np.column_stack((Q, U[:, size**2 > THRESHOLDS.candidate.least_own_squared_sine]))
