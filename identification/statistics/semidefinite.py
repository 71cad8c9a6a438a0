"""Algebra of positive semidefinite matrices whose rounding errors would otherwise leave negative variances."""

from __future__ import annotations

import numpy as np

from haptid.measurement.values.run import Array


def root_of_inverse(matrix: Array) -> Array:
    """Return W (n, n) with W·Wᵀ = matrix⁻¹.

    Unknowns are scaled to a unit diagonal first; eigenvalues below rounding count as at rounding.
    """
    size = 1.0 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(matrix * np.outer(size, size))
    values = np.maximum(values, values.size * np.finfo(float).eps * values.max(initial=0.0))
    return np.asarray(size[:, None] * vectors / np.sqrt(values))


def inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric matrix (n, n) with positive diagonal; its diagonal is positive."""
    root = root_of_inverse(matrix)
    return np.asarray(root @ root.T)


def sandwich(bread: Array, meat: Array) -> Array:
    """Return bread⁻¹·meat·bread⁻¹ (n, n), positive semidefinite."""
    root = root_of_inverse(bread)
    values, vectors = np.linalg.eigh(root.T @ meat @ root)
    half = root @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    return np.asarray(half @ half.T)


def marginal(information: Array, n: int) -> Array:
    """Return the information about the first n unknowns with the others profiled out (Schur's complement).

    By QR of a root of the information with the others' columns first, so that it stays positive semidefinite.
    """
    if information.shape[0] == n:
        return information
    diagonal = np.diag(information)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    others = information.shape[0] - n
    triangle = np.asarray(np.linalg.qr(np.roll(root, others, axis=1), mode="r"))
    R = triangle[others:, others:] * size[:n]
    return np.asarray(R.T @ R)
