"""Compute the tangent space of a fitted model: `Solution` in, orthonormal basis of whitened readings out.

The tangent space holds every change of the readings that parameters and initial states can reproduce to first order.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from haptid.discrepancy.fit.solution import Solution
from haptid.measurement.values.run import Array


def movable(solution: Solution) -> NDArray[np.bool_]:
    """Say which unknowns can move both ways.

    Parameters
    ----------
    solution
        Fitted model.

    Returns
    -------
    ndarray of bool
        True for initial states and for parameters away from their bounds, shape (n,).
    """
    lower, upper = solution.problem.parametrisation.bounds
    n = solution.problem.n_parameters
    s = solution.x[:n]
    # Unbounded parameters get the width 1, since the bounds are in scaled units.
    room = 1e-6 * np.minimum(np.where(np.isfinite(upper - lower), upper - lower, 1.0), 1.0)
    free = np.ones(solution.x.size, dtype=bool)
    free[:n] = (s - lower > room) & (upper - s > room)
    return free


def tangent_space(solution: Solution, without: Collection[str] = ()) -> Array:
    """Return an orthonormal basis of the readings' changes that the model can reproduce.

    Parameters
    ----------
    solution
        Fitted model.
    without
        Ids of parameters that are held.

    Returns
    -------
    ndarray
        Orthonormal basis of the whitened Jacobian's columns, shape (n_r, k), rows of the priors included.
    """
    free = movable(solution)
    moves = [id not in without for id in solution.problem.parametrisation.ids]
    free[: solution.problem.n_parameters] &= np.array(moves, dtype=bool)
    J = solution.blocks.jacobian[:, free]
    # With columns of length 1, the threshold on R below measures angles between columns and not the units of
    # parameters.
    J = J / np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    Q, R, _ = qr(J, mode="economic", pivoting=True)
    kept = np.abs(np.diag(R)) > 1e-9 * abs(R[0, 0]) if R.size else np.zeros(0, dtype=bool)
    return np.asarray(Q[:, kept])
