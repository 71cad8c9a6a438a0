"""Linear least squares under linear inequalities (Lawson & Hanson 1974, chapter 23: LSI by LDP by NNLS)."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from haptid.measurement.values.run import Array


def triangle(J: Array, r: Array) -> tuple[Array, Array]:
    """Return R (n, n) and c (n,) with ‖J·d + r‖² = ‖R·d − c‖² + constant, by QR of [J, r]."""
    n = J.shape[1]
    R: Array = np.asarray(np.linalg.qr(np.column_stack((J, r)), mode="r"))
    if R.shape[0] < n + 1:
        R = np.vstack((R, np.zeros((n + 1 - R.shape[0], n + 1))))
    return R[:n, :n], -R[:n, n]


def step_within(R: Array, c: Array, A: Array, slack: Array) -> Array:
    """Minimise ‖R·d − c‖² subject to A·d ≥ slack, for a regular triangular R (n, n); d has shape (n,).

    With z = R·d − c it is the least distance problem min ‖z‖ subject to G·z ≥ h.
    """
    d = solve_triangular(R, c)
    if not A.size or bool(np.all(A @ d >= slack - 1e-12)):
        return d
    G = solve_triangular(R, A.T, trans="T").T
    h = slack - G @ c
    size = np.maximum(np.abs(h), np.linalg.norm(G, axis=1))
    G, h = G / size[:, None], h / size
    E = np.vstack((G.T, h))
    target = np.zeros(E.shape[0])
    target[-1] = 1.0
    rest = E @ nnls(E, target)[0] - target
    if abs(rest[-1]) < 1e-14:
        return np.zeros_like(d)
    return np.asarray(solve_triangular(R, c - rest[:-1] / rest[-1]), dtype=np.float64)
