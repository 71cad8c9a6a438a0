"""Covariance of the estimates: the sandwich of curvature and of the residuals' own autocovariance.

V = H⁻¹·B·H⁻¹,  H = JᵀJ,  B = Σ_runs Σ_{t,s} c(|t − s|)·g_t·g_sᵀ + J_pᵀJ_p,  g_t = √λ_t·J_t

c(l) is the pooled autocovariance of the residuals over the noise, tapered by Bartlett's window up to the lag at
which it has died away (Newey & West 1987, with the autocovariance taken as stationary). White residuals of the
stated noise give back the classical covariance of weighted least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.problem.residuals import Blocks, Problem
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import sandwich

LONGEST = 0.1
"""Longest lag as a share of the shortest run."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Curvature:
    """At the minimum, in scaled unknowns x (n,): H of everything, of the data alone, and the covariance V."""

    hessian: Array
    data: Array
    covariance: Array
    correlation_time: float


def curvature(problem: Problem, x: Array) -> Curvature:
    """Evaluate the matrices at x; directions that nothing determines get the width of their bounds as variance."""
    blocks = problem.blocks(x)
    n = problem.size
    data = sum((J.reshape(-1, n).T @ J.reshape(-1, n) for J in blocks.jacobians or ()), np.zeros((n, n)))
    prior = blocks.prior_jacobian.T @ blocks.prior_jacobian
    flat = np.diag(flat_information(problem))
    meat, tau = _meat(problem, blocks)
    covariance = sandwich(data + prior + flat, meat + prior + flat)
    alone = data + _start_priors(problem, blocks)
    return Curvature(hessian=data + prior, data=alone, covariance=covariance, correlation_time=tau)


def _start_priors(problem: Problem, blocks: Blocks) -> Array:
    """Information of the priors of initial velocities, which belong to the run rather than to the parameters."""
    rows = blocks.prior_jacobian[:, problem.n_parameters :]
    result = np.zeros((problem.size, problem.size))
    result[problem.n_parameters :, problem.n_parameters :] = rows.T @ rows
    return result


def flat_information(problem: Problem) -> Array:
    """1/variance of a uniform distribution between the bounds, scaled; 0 for initial states and where unbounded."""
    lower, upper = problem.scaling.bounds
    result = np.full(problem.size, 1e-12)
    width = np.where(np.isfinite(upper - lower), upper - lower, 1e6)
    result[: problem.n_parameters] = 12.0 / np.maximum(width, 1e-12) ** 2
    return result


def autocovariance(residuals: tuple[Array, ...], longest: int) -> Array:
    """Return c(0 … longest) pooled over runs and joints; residuals (n_t, n_y) are over the noise, the mean is kept."""
    total, count = np.zeros(longest + 1), np.zeros(longest + 1)
    for r in residuals:
        size = int(2 ** np.ceil(np.log2(2 * r.shape[0])))
        power = np.abs(np.fft.rfft(r, size, axis=0)) ** 2
        total += np.fft.irfft(power, size, axis=0)[: longest + 1].sum(axis=1)
        count += (r.shape[0] - np.arange(longest + 1)) * r.shape[1]
    return np.asarray(total / count)


def _window(c: Array, rows: int) -> Array:
    """Bartlett's weights up to twice the lag at which the correlation enters its own scatter."""
    quiet = np.flatnonzero(np.abs(c) < 2.0 * c[0] / np.sqrt(rows))
    died = int(quiet[0]) if quiet.size else c.size - 1
    last = min(max(2 * died, 1), c.size - 1) if died > 1 else 1
    return np.maximum(0.0, 1.0 - np.arange(last + 1) / (last + 1.0))


def _meat(problem: Problem, blocks: Blocks) -> tuple[Array, float]:
    n = problem.size
    roots = [np.maximum(root, 0.0)[:, None] for root in problem.roots]
    plain = tuple(
        np.where(root > 0, r / np.where(root > 0, root, 1.0), 0.0) for r, root in zip(blocks.rows, roots, strict=True)
    )
    rows = min(r.shape[0] for r in plain)
    c = autocovariance(plain, max(int(LONGEST * rows), 1))
    weights = _window(c, sum(r.size for r in plain)) * c[: _window(c, sum(r.size for r in plain)).size]
    meat = np.zeros((n, n))
    for J, root in zip(blocks.jacobians or (), roots, strict=True):
        for k in range(J.shape[1]):
            g = J[:, k] * root
            meat += weights[0] * g.T @ g
            for lag in range(1, weights.size):
                cross = g[lag:].T @ g[:-lag]
                meat += weights[lag] * (cross + cross.T)
    values, vectors = np.linalg.eigh(meat)
    meat = (vectors * np.maximum(values, 0.0)) @ vectors.T
    tau = float(1.0 + 2.0 * np.sum(weights[1:]) / weights[0]) if weights[0] > 0 else 1.0
    return meat, max(tau, 0.0)
