"""Corners where a descent ends too early: `SumOfSquares` and `Descent` in, `Descent` out.

Where two parameters meet their ordering, as Fs = Fc, another one shapes their difference alone, as vs; where a spring
meets its bound Ks = 0, epos shapes it. The residual has no slope along such a parameter, whatever its value, and yet
whether it would fall if the others parted hangs on that value.

1. Find what the residual does not see, where an ordering or a bound is met.
2. Place it at shares of its range, all such parameters at the same share, and predict what one step gains from there.
3. Minimise again from the most promising place, where it promises more than the corner; go on until none does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from haptid.identification.optimise.levenberg_marquardt import Descent, Steps, SumOfSquares, foresee
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


def leave_corners(
    objective: SumOfSquares,
    reached: Descent,
    minimise: Callable[[Array], Descent],
    *,
    steps: Steps,
    relative: float,
) -> Descent:
    """Minimise again where a descent ended in a corner that it can be led out of.

    Parameters
    ----------
    objective
        The cost that was minimised.
    reached
        Where the descent ended.
    minimise
        Function of unknowns (n,) that minimises the cost from there.
    steps
        How long the steps of that minimiser are.
    relative
        Decrease of the cost over the cost that counts [1].

    Returns
    -------
    Descent
        ``reached`` where it is in no corner, or none of the places promises more; ``calls`` counts all simulations.
    """
    calls = reached.calls
    for _ in range(THRESHOLDS.most_corners_of_descent):
        place, asked = _promising(objective, reached, steps, relative * reached.cost)
        calls += asked
        if place is None:
            break
        again = minimise(place)
        calls += again.calls
        if not again.cost < (1.0 - relative) * reached.cost:
            break
        reached = again
    return replace(reached, calls=calls)


def _promising(objective: SumOfSquares, reached: Descent, steps: Steps, enough: float) -> tuple[Array | None, int]:
    """Return the place that promises most, None where none promises ``enough``, and the number of simulations."""
    if not np.isfinite(reached.cost) or not _is_at_a_limit(objective, reached.x):
        return None, 0
    here = foresee(objective, reached.x, steps)
    if here is None:
        return None, 1
    parametrisation = objective.problem.parametrisation
    lower, upper = parametrisation.bounds
    n, bounded = objective.problem.n_parameters, np.isfinite(upper - lower)
    span = np.where(bounded, upper - lower, 0.0)
    # To first order the cost changes by less than what counts, from one end of the range to the other.
    unseen = bounded & ((here.seen[:n] * span) ** 2 < enough)
    if not unseen.any():
        return None, 1
    shares = np.linspace(0.0, 1.0, THRESHOLDS.places_beside_corner + 2)[1:-1]
    least, best = here.cost - here.predicted - enough, None
    for share in shares:
        place = reached.x.copy()
        place[:n] = parametrisation.put_in_order(np.where(unseen, lower + share * span, place[:n]))
        there = foresee(objective, place, steps)
        if there is not None and there.cost - there.predicted < least:
            least, best = there.cost - there.predicted, place
    return best, 1 + shares.size


def _is_at_a_limit(objective: SumOfSquares, x: Array) -> bool:
    """Say whether a bound or an ordering is met."""
    A, limit = objective.problem.constraints()
    return bool(np.any(A @ x - limit < THRESHOLDS.largest_room_at_limit))
