"""Gaussian likelihoods with a few random columns, marginalised analytically: Gram matrices in, log densities out.

For r ~ N(0, S + U·diag(λ²)·Uᵀ) with few columns U, everything follows from the Gram matrix G of [r, U] under S⁻¹:

log p = −½ (rᵀS⁻¹r − wᵀw + log det S + log det K + n·log 2π),  K = I + Λ·UᵀS⁻¹U·Λ = L·Lᵀ,  w = L⁻¹·Λ·UᵀS⁻¹r

by Woodbury's identity and the matrix determinant lemma (Sherman and Morrison 1950 where U is one column).

References
----------
Sherman, J., and Morrison, W. J. (1950). Adjustment of an inverse matrix corresponding to a change in one element of a
given matrix. Annals of Mathematical Statistics 21, 124–127.
"""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array

LARGEST_FINITE_ENTRY = 1e24
"""Size of K's entries from which the simulation behind them counts as diverged."""


def _capacitance(gram: Array, scales: Array, first: int) -> tuple[Array, Array]:
    """Factor K and solve with it.

    Returns
    -------
    lower : ndarray, shape (…, k, k)
        Cholesky factor L of K.
    w : ndarray, shape (…, k, first)
        L⁻¹·Λ·G[first:, :first], NaN where an entry of K is beyond `LARGEST_FINITE_ENTRY`.
    """
    inner = scales[..., :, None] * gram[..., first:, first:] * scales[..., None, :]
    finite = (np.abs(inner) < LARGEST_FINITE_ENTRY).all(axis=(-1, -2), keepdims=True)
    lower = _factor(np.eye(inner.shape[-1]) + np.where(finite, inner, 0.0))
    right = np.where(finite, scales[..., :, None] * gram[..., first:, :first], np.nan)
    return lower, np.asarray(np.linalg.solve(lower, right), dtype=np.float64)


def _factor(K: Array) -> Array:
    """Return the Cholesky factor of K = I + (positive semidefinite), shape (…, k, k)."""
    try:
        return np.asarray(np.linalg.cholesky(K), dtype=np.float64)
    except np.linalg.LinAlgError:
        # Beside very large entries rounding hides the ones on the diagonal, and K comes out indefinite. Its true
        # eigenvalues are at least 1: lift them, and get the triangular factor of the root by QR.
        values, vectors = np.linalg.eigh(K)
        root = vectors * np.sqrt(np.maximum(values, 1.0))[..., None, :]
        upper = np.linalg.qr(np.swapaxes(root, -1, -2), mode="r")
        signs = np.where(np.diagonal(upper, axis1=-2, axis2=-1) < 0.0, -1.0, 1.0)
        return np.asarray(np.swapaxes(signs[..., :, None] * upper, -1, -2), dtype=np.float64)


def log_marginal(gram: Array, scales: Array, logdet: Array, count: float | Array) -> Array:
    """Return the log density of the data with the random columns marginalised.

    Parameters
    ----------
    gram
        Gram matrix G of [r, U] under S⁻¹, shape (…, 1 + k, 1 + k), the residual first.
    scales
        λ, standard deviations of the k coefficients, shape (…, k).
    logdet
        log det S, shape (…,).
    count
        Number n of rows that were seen.

    Returns
    -------
    ndarray, shape (…,)
        log p as the module's formula gives it.
    """
    lower, w = _capacitance(gram, scales, 1)
    quadratic = gram[..., 0, 0] - np.sum(w[..., 0] ** 2, axis=-1)
    log_k = 2 * np.sum(np.log(np.diagonal(lower, axis1=-2, axis2=-1)), axis=-1)
    return np.asarray(-0.5 * (quadratic + logdet + log_k + count * np.log(2 * np.pi)))


def eliminate(gram: Array, scales: Array, kept: int) -> Array:
    """Return the Gram matrix of the first columns under (S + U·diag(λ²)·Uᵀ)⁻¹, a Schur complement.

    Parameters
    ----------
    gram
        Gram matrix of [kept columns, U] under S⁻¹, shape (…, kept + k, kept + k).
    scales
        λ, standard deviations of the k coefficients of U, shape (…, k).
    kept
        Number of columns before U.

    Returns
    -------
    ndarray, shape (…, kept, kept)
    """
    _, w = _capacitance(gram, scales, kept)
    return np.asarray(gram[..., :kept, :kept] - np.swapaxes(w, -1, -2) @ w)


def coefficients(gram: Array, scales: Array) -> tuple[Array, Array]:
    """Return the conditional mean and covariance of the random columns' coefficients given the residual.

    Parameters
    ----------
    gram, scales
        As in `log_marginal`.

    Returns
    -------
    mean : ndarray, shape (…, k)
        Λ·K⁻¹·Λ·UᵀS⁻¹r.
    covariance : ndarray, shape (…, k, k)
        Λ·K⁻¹·Λ.
    """
    lower, w = _capacitance(gram, scales, 1)
    half = np.linalg.solve(lower, np.eye(lower.shape[-1]) * scales[..., None, :])
    half_t = np.swapaxes(half, -1, -2)
    return np.asarray((half_t @ w)[..., 0]), np.asarray(half_t @ half)
