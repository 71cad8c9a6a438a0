"""Place a discontinuity between two torques that were sent: `Solution` in, equally likely parameter vectors out.

A discontinuity that lies between two neighbouring torques of the fitted runs changes no reading wherever it lies in
between. Torques of other runs may divide that interval.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect


def torques(runs: Sequence[Run], effect: Effect) -> Array:
    """Return the magnitudes of the torques that were sent to the joint of an effect.

    Parameters
    ----------
    runs
        Runs whose torques count.
    effect
        Effect with a discontinuity; the only joint of the runs where it names none.

    Returns
    -------
    ndarray
        Distinct magnitudes, ascending [N m] ([N] for a prismatic joint), shape (n,).
    """
    sent = [run.u[:, 0 if effect.joint is None else run.free_joints.index(effect.joint)] for run in runs]
    return np.unique(np.abs(np.concatenate(sent)))


def around(value: float, sent: Array) -> tuple[float, float]:
    """Return the sent torques next to a discontinuity.

    Parameters
    ----------
    value
        Place of the discontinuity [N m].
    sent
        Torques that were sent, ascending, shape (n,).

    Returns
    -------
    low, high
        Torques next below and next above ``value`` [N m]; the first or the last torque twice where ``value`` lies
        outside.
    """
    k = int(np.searchsorted(sent, value))
    return float(sent[max(k - 1, 0)]), float(sent[min(k, sent.size - 1)])


def places(solution: Solution, fitted: Sequence[Run], others: Sequence[Run]) -> tuple[Array, ...]:
    """Return parameter vectors with the discontinuity at every place that the fitted runs cannot tell apart.

    Parameters
    ----------
    solution
        Fitted model.
    fitted
        Runs of the fit; their torques bound each discontinuity.
    others
        Runs to predict; their torques divide the interval in which the discontinuity may lie.

    Returns
    -------
    tuple of ndarray
        Parameters, shape (n_p,) each, the fitted ones first. Without a discontinuity there are no others.
    """
    found = [solution.theta]
    ids = [q.id for q in solution.equations.parameters]
    for effect in [e for e in solution.effects if e.threshold]:
        sent = torques(others, effect)
        at = ids.index(effect.parameters[0].id)
        value = float(solution.theta[at])
        low, high = around(value, torques(fitted, effect))
        ends = np.concatenate(([low], sent[(sent > low) & (sent < high)], [high]))
        # One place in each part of the interval is enough, and the fitted value already stands for its own part.
        middles = [float(a + b) / 2 for a, b in itertools.pairwise(ends) if not a <= value <= b]
        for middle in sorted(middles, key=lambda d: abs(d - value))[: THRESHOLDS.fit.most_places_of_discontinuity]:
            moved = solution.theta.copy()
            moved[at] = middle
            found.append(moved)
    return tuple(found)
