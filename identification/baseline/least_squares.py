"""Weighted least squares of torque equations: columns and torques of runs in, `LeastSquares` out.

1. Solve all rows together, inertia and friction not negative; a column that its predecessors explain is left out.
2. Weight every joint of every run by the RMS of its residual, and solve again.
3. Give the parameters the covariance of blocks: with the residual's moments summed within blocks of several
   correlation lengths, (WᵀW)⁻¹·Σ_b (W_bᵀe_b)(W_bᵀe_b)ᵀ·(WᵀW)⁻¹, so that what is systematic in the residual counts
   (Liang and Zeger 1986).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import column_rms, rms, sandwich


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastSquares:
    """Estimate of a linear model.

    Parameters
    ----------
    theta
        Parameters, shape (n,); 0 where a column was left out, or where the data ask for a negative value.
    covariance
        Covariance of blocks, shape (n, n); NaN rows and columns of parameters that are 0 for one of these reasons.
    """

    theta: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations, shape (n,); NaN where the covariance is."""
        return np.sqrt(np.diag(self.covariance))


def weighted_least_squares(columns: Sequence[Array], torques: Sequence[Array], nonnegative: Array) -> LeastSquares:
    """Solve τ = W·θ over all runs, θ_k ≥ 0 where ``nonnegative``.

    Parameters
    ----------
    columns
        Per run, shape (n_t, n_joints, n).
    torques
        Per run, shape (n_t, n_joints).
    nonnegative
        Whether physics forbids a negative value, shape (n,).

    Returns
    -------
    LeastSquares
    """
    kept = independent_columns(np.concatenate([W.reshape(-1, W.shape[2]) for W in columns]))
    used = [W[:, :, kept] for W in columns]
    weights = [np.ones(tau.shape[1]) for tau in torques]
    theta = np.zeros(int(kept.sum()))
    for _ in range(THRESHOLDS.weighted_solutions):
        A = np.concatenate([(W * w[:, None]).reshape(-1, theta.size) for W, w in zip(used, weights, strict=True)])
        b = np.concatenate([(tau * w).ravel() for tau, w in zip(torques, weights, strict=True)])
        theta = _solve(A, b, nonnegative[kept])
        residuals = [tau - W @ theta for W, tau in zip(used, torques, strict=True)]
        weights = [
            1.0 / np.maximum(column_rms(e), THRESHOLDS.least_residual_torque_over_torque * _rms(b)) for e in residuals
        ]
    full, covariance = np.zeros(kept.size), np.full((kept.size, kept.size), np.nan)
    full[kept] = theta
    inside = ~nonnegative[kept] | (theta > 0)
    places = np.flatnonzero(kept)[inside]
    covariance[np.ix_(places, places)] = block_covariance([W[:, :, inside] for W in used], residuals, weights)
    return LeastSquares(theta=full, covariance=covariance)


def _solve(A: Array, b: Array, nonnegative: Array) -> Array:
    """Return the least-squares solution within its bounds, by the triangular factor of A with columns of unit size."""
    size = np.linalg.norm(A, axis=0)
    R, c = triangle(A / size, -b)
    lower = np.where(nonnegative, 0.0, -np.inf)
    bounded = lsq_linear(R, c, bounds=(lower, np.inf), method="bvls")
    # BVLS ends at a tolerance; with its active bounds known, the others follow exactly.
    free = bounded.active_mask == 0
    theta = np.zeros(size.size)
    theta[free] = np.linalg.lstsq(R[:, free], c, rcond=None)[0]
    return np.asarray(np.where(nonnegative, np.maximum(theta, 0.0), theta) / size)


def _rms(values: Array) -> float:
    return rms(values) or 1.0


def independent_columns(A: Array) -> Array:
    """Say which columns the earlier ones do not explain.

    Parameters
    ----------
    A
        Columns of any size, shape (n_rows, n).

    Returns
    -------
    ndarray of bool, shape (n,)
        False where less than `THRESHOLDS.least_new_part_of_column` of a column is new, and beyond the first n_rows.
    """
    size = np.linalg.norm(A, axis=0)
    new = np.abs(np.diag(np.linalg.qr(A / np.where(size > 0, size, 1.0), mode="r")))
    # R has as many rows as A where these are fewer than the columns.
    new = np.pad(new, (0, size.size - new.size))
    return np.asarray((new > THRESHOLDS.least_new_part_of_column) & (size > 0))


def correlation_length(residual: Array) -> float:
    """Return the integrated autocorrelation time of a residual.

    Parameters
    ----------
    residual
        Shape (n,).

    Returns
    -------
    float
        1 + 2·Σ ρ_k [rows], the sum ended at the first ρ_k below 0.
    """
    e = residual - residual.mean()
    n = e.size
    power = np.abs(np.fft.rfft(e, 2 * n)) ** 2
    rho = np.fft.irfft(power)[:n]
    if rho[0] <= 0:
        return 1.0
    rho = rho / rho[0]
    below = np.flatnonzero(rho < 0)
    return float(1.0 + 2.0 * rho[1 : below[0] if below.size else n].sum())


def blocks_of(residuals: Sequence[Array]) -> list[int]:
    """Choose into how many blocks the rows of each run are cut.

    Parameters
    ----------
    residuals
        Residual torque by run, shape (n_t, n_joints).

    Returns
    -------
    list of int
        Blocks of `THRESHOLDS.block_of_residual_in_correlation_lengths`, at least
        `THRESHOLDS.least_residual_blocks_of_run` a run.
    """
    counts = []
    for r in residuals:
        longest = max(correlation_length(column) for column in r.T)
        block = THRESHOLDS.block_of_residual_in_correlation_lengths * longest
        counts.append(max(int(r.shape[0] / block), THRESHOLDS.least_residual_blocks_of_run))
    return counts


def block_covariance(columns: Sequence[Array], residuals: Sequence[Array], weights: Sequence[Array]) -> Array:
    """Compute the covariance of weighted estimates from the moments of blocks of the residual.

    Parameters
    ----------
    columns
        Per run, shape (n_t, n_joints, n).
    residuals
        Per run, shape (n_t, n_joints).
    weights
        Per run, shape (n_joints,).

    Returns
    -------
    ndarray, shape (n, n)
    """
    n = columns[0].shape[2]
    normal, moments = np.zeros((n, n)), np.zeros((n, n))
    blocks, scale = 0, np.zeros(n)
    for W in columns:
        scale += np.sum(W**2, axis=(0, 1))
    scale = np.sqrt(np.maximum(scale, np.finfo(float).tiny))
    counts = blocks_of([e * w for e, w in zip(residuals, weights, strict=True)])
    for W, e, w, count in zip(columns, residuals, weights, counts, strict=True):
        A, r = (W * w[:, None]) / scale, e * w
        normal += np.einsum("tjk,tjl->kl", A, A)
        for rows in np.array_split(np.arange(r.shape[0]), count):
            moment = np.einsum("tjk,tj->k", A[rows], r[rows])
            moments += np.outer(moment, moment)
        blocks += count
    # As many blocks as there are, less the parameters that they determine.
    freedom = blocks / max(blocks - n, 1)
    return np.asarray(freedom * sandwich(normal, moments) / np.outer(scale, scale))
