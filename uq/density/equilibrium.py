"""Static equilibrium of a joint without torque, about which scatter of the reading's amplitude acts.

Equations and parameter sets in, positions [rad] out.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from haptid.measurement.values.run import Array
from haptid.model.equations.equations import TIME, Equations

MOST_NEWTON_STEPS = 12
LARGEST_LAST_STEP_RAD = 1e-14
"""Newton step [rad] below which the iteration has converged."""


@lru_cache(maxsize=64)
def _static_torque(equations: Equations) -> Callable[..., Any]:
    """Return acceleration and its derivative in q as functions of (q, parameters), at v = z = 0, no input and t = 0."""
    q = equations.states[0].symbol
    still: dict[sp.Symbol, Any] = dict.fromkeys(
        [s.symbol for s in equations.states[1:]] + [u.symbol for u in equations.inputs], 0
    )
    still[TIME] = 0
    force = equations.rhs[len(equations.joints)]
    for symbol, expression in reversed(equations.definitions):  # a definition may use only those before it
        force = force.subs(symbol, expression)
    force = sp.sympify(force).subs(still)
    arguments = (q, *(x.symbol for x in equations.parameters))
    return sp.lambdify(arguments, (force, sp.diff(force, q)), "numpy", cse=True)


def equilibrium(equations: Equations, thetas: Array, guess: float | Array) -> Array:
    """Solve f(q; θ) = 0 for the static balance of spring and gravity by Newton's method from ``guess``.

    Parameters
    ----------
    equations
        Equations of the free joint.
    thetas
        Parameter sets, shape (n_sets, n_p).
    guess
        Start [rad], scalar or shape (n_sets,); also the answer where there is no stable balance within a turn of it.

    Returns
    -------
    ndarray, shape (n_sets,)
        Equilibrium positions [rad].
    """
    function = _static_torque(equations)
    columns = tuple(thetas.T)
    start = np.broadcast_to(np.asarray(guess, dtype=np.float64), thetas.shape[:1])
    q = start.copy()
    with np.errstate(all="ignore"):
        for _ in range(MOST_NEWTON_STEPS):
            force, slope = (np.broadcast_to(x, q.shape) for x in function(q, *columns))
            # Only a negative slope is that of a stable balance; elsewhere the iterate stays: ``settled`` refuses it.
            change = np.where(slope < 0, force / np.where(slope < 0, slope, -1.0), 0.0)
            q = q - change
            if np.all(np.abs(change) < LARGEST_LAST_STEP_RAD):
                break
        force, slope = (np.broadcast_to(x, q.shape) for x in function(q, *columns))
        settled = (
            (slope < 0) & np.isfinite(q) & (np.abs(force) < 1e-6 * np.abs(slope)) & (np.abs(q - start) < 2 * np.pi)
        )
    return np.asarray(np.where(settled, q, start))
