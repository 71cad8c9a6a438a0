"""The tangent space of a fitted model: what parameters and initial states can still move, as whitened readings."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from haptid.discrepancy.fit.solution import Solution
from haptid.measurement.values.run import Array


def movable(solution: Solution) -> NDArray[np.bool_]:
    """Which unknowns can move both ways: parameters away from their bounds, and initial states; shape (n,)."""
    lower, upper = solution.problem.scaling.bounds
    n = solution.problem.n_parameters
    s = solution.x[:n]
    room = 1e-6 * np.minimum(np.where(np.isfinite(upper - lower), upper - lower, 1.0), 1.0)
    free = np.ones(solution.x.size, dtype=bool)
    free[:n] = (s - lower > room) & (upper - s > room)
    return free


def tangent_space(solution: Solution, without: Collection[str] = ()) -> Array:
    """Orthonormal basis (n_r, k) of what parameters and initial states can move, rows of the priors included.

    The parameters ``without`` stand still.
    """
    free = movable(solution)
    moves = [id not in without for id in solution.problem.scaling.ids]
    free[: solution.problem.n_parameters] &= np.array(moves, dtype=bool)
    J = solution.blocks.jacobian[:, free]
    J = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    Q, R, _ = qr(J, mode="economic", pivoting=True)
    kept = np.abs(np.diag(R)) > 1e-9 * abs(R[0, 0]) if R.size else np.zeros(0, dtype=bool)
    return np.asarray(Q[:, kept])
