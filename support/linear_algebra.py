"""Linear algebra of fits: inverses and Schur complements that stay positive semidefinite, whatever the units.

Information matrices and Jacobians come in, inverses, covariances and Schur complements go out. Unknowns of very
different sizes are scaled first, so that the threshold of rounding does not depend on their units. The results are
formed from matrix roots, so that they stay positive semidefinite.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import qr

Array = NDArray[np.float64]

ROUNDING_OVER_LARGEST_EIGENVALUE = 1e-12
"""Ratio to the largest eigenvalue of a scaled matrix below which an eigenvalue is rounding [1]."""
ROUNDING_OVER_LARGEST_COLUMN = 1e-9
"""Length of a unit column's part outside other columns below which that part is rounding [1]."""


def root_of_inverse(matrix: Array) -> Array:
    """Return W with W·Wᵀ = matrix⁻¹.

    Parameters
    ----------
    matrix
        Symmetric, positive semidefinite, with positive diagonal, shape (n, n).

    Returns
    -------
    ndarray, shape (n, n)

    Notes
    -----
    The matrix is scaled to a unit diagonal first. Eigenvalues below n·ε times the largest, ε the machine precision, are
    lifted to it.
    """
    # The square root of the smallest number leaves room for products: W·Wᵀ of what says nothing stays finite.
    least = np.sqrt(np.finfo(float).tiny)
    seen = np.diag(matrix) > least
    size = 1.0 / np.sqrt(np.where(seen, np.diag(matrix), least))
    # Beside a diagonal of 0 the other elements of a positive matrix are 0; what is left there is rounding.
    scaled = np.where(np.outer(seen, seen), matrix, 0.0) * np.outer(size, size)
    np.fill_diagonal(scaled, 1.0)
    values, vectors = np.linalg.eigh(scaled)
    values = np.maximum(values, values.size * np.finfo(float).eps * values.max(initial=0.0))
    return np.asarray(size[:, None] * vectors / np.sqrt(values))


def inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric matrix.

    Parameters
    ----------
    matrix
        Positive semidefinite, with positive diagonal, shape (n, n).

    Returns
    -------
    ndarray, shape (n, n)
        W·Wᵀ of `root_of_inverse`: positive semidefinite with positive diagonal, also where rounding makes ``matrix``
        indefinite.
    """
    root = root_of_inverse(matrix)
    return np.asarray(root @ root.T)


def sandwich(bread: Array, meat: Array) -> Array:
    """Return the sandwich covariance bread⁻¹·meat·bread⁻¹.

    Parameters
    ----------
    bread
        Information matrix, symmetric with positive diagonal, shape (n, n).
    meat
        Covariance of the score, symmetric, shape (n, n).

    Returns
    -------
    ndarray, shape (n, n)
        Positive semidefinite.
    """
    root = root_of_inverse(bread)
    values, vectors = np.linalg.eigh(root.T @ meat @ root)
    half = root @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    return np.asarray(half @ half.T)


def profile_out(information: Array, places: Sequence[int]) -> Array:
    """Return the information about some unknowns with all others profiled out (Schur's complement).

    Parameters
    ----------
    information
        Information matrix I, positive semidefinite, shape (n, n).
    places
        Indices of the unknowns that are kept.

    Returns
    -------
    ndarray, shape (len(places), len(places))
        I_aa − I_ab·I_bb⁺·I_ba with a the unknowns that are kept and b the others.

    Notes
    -----
    With I = RᵀR the complement is the Gram matrix of R's columns a less their projection onto its columns b. The
    difference of the formula could come out indefinite by rounding. Directions of b that the data do not determine have
    singular values of rounding and are left out of the projection: they reduce no information about a.
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
    taken = U[:, s > np.sqrt(ROUNDING_OVER_LARGEST_EIGENVALUE) * s.max(initial=0.0)]
    left = root[:, kept] - taken @ (taken.T @ root[:, kept])
    left = left * size[kept]
    return np.asarray(left.T @ left)


def rms(values: ArrayLike) -> float:
    """Return the root mean square.

    Parameters
    ----------
    values
        Numbers in any unit, of any shape.

    Returns
    -------
    float
        In the unit of ``values``; NaN for none.
    """
    return float(np.sqrt(np.mean(np.square(values))))


def largest_magnitude(*values: ArrayLike) -> float:
    """Return the largest magnitude among the finite numbers.

    Parameters
    ----------
    *values
        Numbers in one unit, of any shapes.

    Returns
    -------
    float
        In the unit of ``values``; 0 where none is finite.
    """
    numbers = np.concatenate([np.ravel(one) for one in values]) if values else np.empty(0)
    return float(np.max(np.abs(numbers[np.isfinite(numbers)]), initial=0.0))


def column_rms(values: ArrayLike) -> Array:
    """Return the root mean square of every column.

    Parameters
    ----------
    values
        Numbers in any unit, shape (n, …).

    Returns
    -------
    ndarray, shape (…)
        In the unit of ``values``.
    """
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=0)))


def column_sizes(jacobian: Array) -> Array:
    """Return the norms of a Jacobian's columns.

    Parameters
    ----------
    jacobian
        Shape (n_r, n).

    Returns
    -------
    ndarray, shape (n,)
        At least 1e-300, so that a column of zeros can be divided by its norm.
    """
    return np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)


def orthonormal_basis(columns: Array) -> Array:
    """Return an orthonormal basis of what columns span, by a pivoted QR decomposition.

    Parameters
    ----------
    columns
        Columns in any units, shape (n, k).

    Returns
    -------
    ndarray, shape (n, r)
        r ≤ k: a column whose part outside the others is below `ROUNDING_OVER_LARGEST_COLUMN` of it adds none.
    """
    # Columns of length 1 make the threshold one of the angles between columns and not of their units.
    Q, R, _ = qr(columns / column_sizes(columns), mode="economic", pivoting=True)
    size = np.abs(np.diag(R))
    return np.asarray(Q[:, size > ROUNDING_OVER_LARGEST_COLUMN * size.max(initial=0.0)])


def correlation_of(covariance: Array) -> tuple[Array, Array]:
    """Return the correlation matrix of a covariance, and its standard deviations.

    Parameters
    ----------
    covariance
        Positive semidefinite, shape (n, n).

    Returns
    -------
    correlation, std : ndarray, shape (n, n) and (n,)
        A variance of 0 has the tiny standard deviation 1e-150, so that nothing is divided by 0.
    """
    std = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return np.asarray(covariance / np.outer(std, std)), np.asarray(std)


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


def symmetric_inverse(matrix: Array, rounding: float = ROUNDING_OVER_LARGEST_EIGENVALUE) -> Array:
    """Return the Moore–Penrose inverse of a symmetric matrix whose unknowns are scaled already.

    Parameters
    ----------
    matrix
        Symmetric, shape (n, n).
    rounding
        Ratio to the largest eigenvalue below which an eigenvalue counts as 0 [1].

    Returns
    -------
    ndarray, shape (n, n)
    """
    return np.asarray(np.linalg.pinv(matrix, rcond=rounding, hermitian=True))
