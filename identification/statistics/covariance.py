"""Covariance of the estimates: `Problem` and minimum in, `Curvature` with the sandwich covariance out.

V = H⁻¹·B·H⁻¹,  H = JᵀJ,  B = Σ_runs Σ_{t,s} c(|t − s|)·g_t·g_sᵀ + J_pᵀJ_p,  g_t = √λ_t·J_t

c(l) is the pooled autocovariance of the residuals over the noise, tapered by Bartlett's window up to twice the lag at
which it enters its own scatter (Newey & West 1987, with the autocovariance taken as stationary). White residuals of the
stated noise give the classical covariance of weighted least squares.

1. Simulate at the minimum and form H from the Jacobians of runs and priors.
2. Remove the time weights from the residuals and estimate c(l) from all runs and joints.
3. Form B from c(l) and the weighted Jacobians, and make B positive semidefinite.
4. Add the information of uniform distributions between the bounds, and form the sandwich.

A spring that pulls from far outside the travel is a constant torque: Ks is then known as well as that torque divided by
the distance, which says nothing of a spring within the travel. Where Ks is not told from 0 by a spring whose
equilibrium lies amid the travel, the Jacobians are taken there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import oaconvolve

from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.problem.valleys import Valleys
from haptid.identification.result.fit import scatter_of_correlation
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.support.linear_algebra import sandwich


@dataclass(frozen=True, slots=True, kw_only=True)
class Curvature:
    """Information and covariance at the minimum, in the scaled unknowns x (n,).

    Parameters
    ----------
    hessian
        H = JᵀJ of data and priors, shape (n, n).
    data
        H of the data and of the priors of initial velocities, shape (n, n).
    covariance
        Sandwich covariance V, shape (n, n).
    correlation_time
        Integrated autocorrelation time 1 + 2·Σ c(l)/c(0) of the residuals, tapered [rows]; 1 is white.
    """

    hessian: Array
    data: Array
    covariance: Array
    correlation_time: float


def curvature(problem: Problem, x: Array) -> Curvature:
    """Compute Hessian and sandwich covariance at the minimum.

    Parameters
    ----------
    problem
        Problem that was minimised.
    x
        Minimum, shape (n,).

    Returns
    -------
    Curvature
        A direction that neither data nor priors determine has the variance of a uniform distribution between its
        bounds.
    """
    blocks = problem.blocks(x)
    found = _curvature(problem, blocks)
    amid = _springs_amid_travel(problem, x)
    if np.array_equal(amid, x):
        return found
    there = problem.blocks(amid)
    if not all(np.isfinite(J).all() for J in there.jacobians or ()):
        return found
    # The residuals stay those of the minimum, which an equilibrium elsewhere need not be.
    other = _curvature(problem, replace(blocks, jacobians=there.jacobians))
    reach = THRESHOLDS.standard_errors_of_interval * np.sqrt(np.maximum(np.diag(other.covariance), 0.0))
    springs = Valleys.of(problem.parametrisation).springs
    seen = [abs(float(spring.physical(x)[0])) > reach[spring.stiffness] * spring.stiffness_unit for spring in springs]
    return found if any(seen) else other


def _springs_amid_travel(problem: Problem, x: Array) -> Array:
    """Return x with each equilibrium that lies outside the travel of the runs moved to the middle of their readings."""
    joints, moved = problem.simulator.equations.joints, x.copy()
    for spring in Valleys.of(problem.parametrisation).springs:
        if spring.log:
            continue
        tail = problem.parametrisation.ids[spring.stiffness].rpartition("_")[2]
        column = joints.index(int(tail)) if tail.isdigit() and int(tail) in joints else 0
        q = np.concatenate([_positions(problem, run)[:, column] for run in problem.runs])
        equilibrium = float(spring.physical(x)[1])
        if not q.min() <= equilibrium <= q.max():
            moved[spring.position] = (float(np.mean(q)) - spring.position_centre) / spring.position_unit
    return moved


def _positions(problem: Problem, run: Run) -> Array:
    """Return the measured positions of a run, which drive the equations where their torque is fitted."""
    return run.u if isinstance(problem.simulator, TorqueSimulator) else run.y


def _curvature(problem: Problem, blocks: Blocks) -> Curvature:
    n = problem.size
    data = sum((J.reshape(-1, n).T @ J.reshape(-1, n) for J in blocks.jacobians or ()), np.zeros((n, n)))
    prior = blocks.prior_jacobian.T @ blocks.prior_jacobian
    flat = np.diag(flat_information(problem))
    meat, tau = _meat(problem, blocks)
    covariance = sandwich(data + prior + flat, meat + prior + flat)
    alone = data + _start_priors(problem, blocks)
    return Curvature(hessian=data + prior, data=alone, covariance=covariance, correlation_time=tau)


def _start_priors(problem: Problem, blocks: Blocks) -> Array:
    """Return the information of the priors of initial velocities, which belong to the runs, not to the parameters."""
    rows = blocks.prior_jacobian[:, problem.n_parameters :]
    result = np.zeros((problem.size, problem.size))
    result[problem.n_parameters :, problem.n_parameters :] = rows.T @ rows
    return result


def flat_information(problem: Problem) -> Array:
    """Return the information of a uniform distribution between the bounds of each parameter.

    Parameters
    ----------
    problem
        Problem with the bounds.

    Returns
    -------
    ndarray, shape (n,)
        12/width² in scaled unknowns; about 0 (1e-12 to 1e-11) for initial states and for parameters without bounds.
    """
    lower, upper = problem.parametrisation.bounds
    result = np.full(problem.size, 1e-12)
    width = np.where(np.isfinite(upper - lower), upper - lower, 1e6)
    result[: problem.n_parameters] = 12.0 / np.maximum(width, 1e-12) ** 2
    return result


def autocovariance(residuals: tuple[Array, ...], longest: int) -> Array:
    """Estimate the autocovariance of residuals, pooled over runs and joints.

    Parameters
    ----------
    residuals
        Residuals over the noise by run, shape (n_t, n_y) each; their mean is not subtracted.
    longest
        Longest lag [rows].

    Returns
    -------
    ndarray, shape (longest + 1,)
        c(l) = Σ r_t·r_{t+l}/count(l), for l = 0 … longest.
    """
    total, count = np.zeros(longest + 1), np.zeros(longest + 1)
    for r in residuals:
        # Zeros up to twice the length at least: the circular correlation of the transform does not wrap around.
        size = int(2 ** np.ceil(np.log2(2 * r.shape[0])))
        power = np.abs(np.fft.rfft(r, size, axis=0)) ** 2
        total += np.fft.irfft(power, size, axis=0)[: longest + 1].sum(axis=1)
        count += (r.shape[0] - np.arange(longest + 1)) * r.shape[1]
    return np.asarray(total / count)


def sum_over_lags(g: Array, weights: Array) -> Array:
    """Sum the products of rows that lie a lag apart, each lag with its weight.

    Parameters
    ----------
    g
        Rows, shape (n_t, n).
    weights
        Weight w_l of the lags l = 0 … L, shape (L + 1,).

    Returns
    -------
    ndarray, shape (n, n)
        w_0·Σ_t g_t·g_tᵀ + Σ_l w_l·Σ_t (g_{t+l}·g_tᵀ + g_t·g_{t+l}ᵀ), which is GᵀKG with the Toeplitz matrix K of w: one
        convolution along the rows in place of a product for every lag.
    """
    kernel = np.concatenate([weights[:0:-1], weights])[:, None]
    total = g.T @ oaconvolve(g, kernel, mode="same", axes=0)
    return np.asarray((total + total.T) / 2.0)


def tapered_autocovariance(residuals: tuple[Array, ...]) -> Array:
    """Estimate the autocovariance of residuals as far as it stands out from its own scatter.

    Parameters
    ----------
    residuals
        As `autocovariance` takes them.

    Returns
    -------
    ndarray, shape (n_lags,)
        c(l) with Bartlett's weights up to twice the lag at which it enters its scatter.
    """
    rows = min(r.shape[0] for r in residuals)
    c = autocovariance(residuals, max(int(THRESHOLDS.longest_lag_over_rows * rows), 1))
    window = _window(c, sum(r.size for r in residuals))
    return np.asarray(window * c[: window.size])


def correlation_time(tapered: Array) -> float:
    """Return the integrated autocorrelation time 1 + 2·Σ c(l)/c(0).

    Parameters
    ----------
    tapered
        What `tapered_autocovariance` returns.

    Returns
    -------
    float
        In rows; 1 is white, as is a residual of 0.
    """
    return max(float(1.0 + 2.0 * np.sum(tapered[1:]) / tapered[0]), 0.0) if tapered[0] > 0 else 1.0


def _window(c: Array, rows: int) -> Array:
    """Return Bartlett's weights up to twice the lag at which the correlation enters its own scatter."""
    quiet = np.flatnonzero(np.abs(c) < c[0] * scatter_of_correlation(rows))
    died = int(quiet[0]) if quiet.size else c.size - 1
    last = min(max(2 * died, 1), c.size - 1) if died > 1 else 1
    return np.maximum(0.0, 1.0 - np.arange(last + 1) / (last + 1.0))


def _meat(problem: Problem, blocks: Blocks) -> tuple[Array, float]:
    n = problem.size
    # Residuals without their time weights: c(l) is stationary only if the weights do not change it along the run.
    roots = [np.maximum(root, 0.0)[:, None] for root in problem.roots]
    plain = tuple(
        np.where(root > 0, r / np.where(root > 0, root, 1.0), 0.0) for r, root in zip(blocks.rows, roots, strict=True)
    )
    weights = tapered_autocovariance(plain)
    meat = np.zeros((n, n))
    for J, root in zip(blocks.jacobians or (), roots, strict=True):
        for k in range(J.shape[1]):
            g = J[:, k] * root
            meat += sum_over_lags(g, weights)
    # Rounding and the estimated c(l) may give slightly negative eigenvalues, which a covariance cannot have.
    values, vectors = np.linalg.eigh(meat)
    meat = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return meat, correlation_time(weights)
