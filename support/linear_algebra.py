"""Linear algebra of fits: inverses and Schur complements that stay positive semidefinite, whatever the units.

Unknowns of very different sizes are scaled first, so that what counts as rounding does not depend on their units.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUNDING = 1e-12
"""Eigenvalues of a scaled matrix below this share of the largest are rounding."""


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


def profiled(information: Array, places: Sequence[int]) -> Array:
    """Return the information about the unknowns at ``places`` with all others profiled out (Schur's complement).

    I_aa − I_ab·I_bb⁺·I_ba, as the columns of a root of the information less their projection on the others' columns: a
    difference of large matrices could come out indefinite. Directions of the others that nothing determines take
    nothing away.

    Parameters
    ----------
    information
        Positive semidefinite, shape (n, n).
    places
        Indices of the unknowns that are kept.

    Returns
    -------
    ndarray, shape (len(places), len(places))
    """
    kept = list(places)
    others = [k for k in range(len(information)) if k not in kept]
    if not others:
        return np.asarray(information[np.ix_(kept, kept)])
    diagonal = np.diag(information)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    U, s, _ = np.linalg.svd(root[:, others], full_matrices=False)
    taken = U[:, s > np.sqrt(ROUNDING) * s.max(initial=0.0)]
    left = root[:, kept] - taken @ (taken.T @ root[:, kept])
    left = left * size[kept]
    return np.asarray(left.T @ left)


def column_sizes(jacobian: Array) -> Array:
    """Return the norms of a Jacobian's columns, never 0; shape (n,)."""
    return np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)


def scaled_covariance(jacobian: Array) -> tuple[Array, Array]:
    """Return the covariance of least squares in columns of unit norm, and the columns' norms.

    Parameters
    ----------
    jacobian
        ∂r/∂x of residuals over their noise, shape (n_r, n).

    Returns
    -------
    covariance : ndarray, shape (n, n)
        (DᵀD)⁺ with D = J·diag(1/size): covariance[i, j]/(size[i]·size[j]) is that of x.
    size : ndarray, shape (n,)
        Norms of the columns.
    """
    size = column_sizes(jacobian)
    scaled = jacobian / size
    return symmetric_inverse(scaled.T @ scaled), size


def symmetric_inverse(matrix: Array, rounding: float = ROUNDING) -> Array:
    """Return the Moore-Penrose inverse of a symmetric matrix (n, n) whose unknowns are scaled already."""
    return np.asarray(np.linalg.pinv(matrix, rcond=rounding, hermitian=True))
