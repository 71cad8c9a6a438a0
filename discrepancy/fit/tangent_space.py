"""Compute the tangent space of a fitted model: `Solution` in, orthonormal basis of whitened readings out.

The tangent space holds every change of the readings that parameters and initial states can reproduce to first order.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from haptid.discrepancy.fit.solution import Solution
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import orthonormal_basis


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
    return orthonormal_basis(solution.blocks.jacobian[:, free])
