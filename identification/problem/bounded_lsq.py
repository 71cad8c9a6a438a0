"""Linear least squares under linear inequalities: Jacobian, residual and constraints in, step out.

1. `triangle` reduces min ‖J·d + r‖² to min ‖R·d − c‖² with a triangular R of the size of d.
2. `step_within` solves the reduced problem subject to A·d ≥ slack: least squares with inequalities (LSI) becomes a
   least distance problem (LDP), and that one a non-negative least-squares problem (NNLS).

References
----------
Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from haptid.measurement.values.run import Array


def triangle(J: Array, r: Array) -> tuple[Array, Array]:
    """Reduce a linear least-squares problem to triangular form by a QR decomposition of [J, r].

    Parameters
    ----------
    J
        Jacobian, shape (n_r, n).
    r
        Residual, shape (n_r,).

    Returns
    -------
    R : ndarray, shape (n, n)
        Upper triangular matrix with RᵀR = JᵀJ.
    c : ndarray, shape (n,)
        Right-hand side: ‖J·d + r‖² = ‖R·d − c‖² + constant for every d.
    """
    n = J.shape[1]
    R: Array = np.asarray(np.linalg.qr(np.column_stack((J, r)), mode="r"))
    # Fewer rows than columns give a trapezoid: rows of zeros make R square, so that callers need no special case.
    if R.shape[0] < n + 1:
        R = np.vstack((R, np.zeros((n + 1 - R.shape[0], n + 1))))
    return R[:n, :n], -R[:n, n]


def step_within(R: Array, c: Array, A: Array, slack: Array) -> Array:
    """Minimise ‖R·d − c‖² subject to A·d ≥ slack.

    Parameters
    ----------
    R
        Regular upper triangular matrix, shape (n, n).
    c
        Right-hand side, shape (n,).
    A, slack
        Linear inequalities, shapes (n_c, n) and (n_c,).

    Returns
    -------
    ndarray, shape (n,)
        The step d; zero where the inequalities contradict each other to rounding.

    Notes
    -----
    With z = R·d − c the problem is the least distance problem min ‖z‖ subject to G·z ≥ h, where G = A·R⁻¹ and
    h = slack − G·c. Its solution follows from the residual ρ of the non-negative least-squares problem
    min ‖[Gᵀ; hᵀ]·u − (0, …, 0, 1)ᵀ‖ with u ≥ 0 as z_i = −ρ_i/ρ_{n+1}.
    """
    # The unconstrained minimum is the solution wherever it is feasible.
    d = solve_triangular(R, c)
    if not A.size or bool(np.all(A @ d >= slack - 1e-12)):
        return d
    G = solve_triangular(R, A.T, trans="T").T
    h = slack - G @ c
    # Rows of unit size: an inequality may be multiplied by a positive number, and NNLS compares the rows.
    size = np.maximum(np.abs(h), np.linalg.norm(G, axis=1))
    G, h = G / size[:, None], h / size
    E = np.vstack((G.T, h))
    target = np.zeros(E.shape[0])
    target[-1] = 1.0
    rest = E @ nnls(E, target)[0] - target
    # A residual of zero means that no z meets the inequalities.
    if abs(rest[-1]) < 1e-14:
        return np.zeros_like(d)
    return np.asarray(solve_triangular(R, c - rest[:-1] / rest[-1]), dtype=np.float64)
