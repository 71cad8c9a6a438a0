"""Where a jump lies: between two torques that were sent, its place changes nothing, so it may be anywhere there."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import Effect

MOST = 8
"""Most places of the jump between two fitted torques that are told apart by torques of other runs."""


def torques(runs: Sequence[Run], effect: Effect) -> Array:
    """Sizes of the torques that were sent to the joint of an effect, each once, ascending."""
    sent = [run.u[:, 0 if effect.joint is None else run.free_joints.index(effect.joint)] for run in runs]
    return np.unique(np.abs(np.concatenate(sent)))


def around(value: float, sent: Array) -> tuple[float, float]:
    """Return the torques sent next below and next above ``value``."""
    k = int(np.searchsorted(sent, value))
    return float(sent[max(k - 1, 0)]), float(sent[min(k, sent.size - 1)])


def places(solution: Solution, fitted: Sequence[Run], others: Sequence[Run]) -> tuple[Array, ...]:
    """Parameters (n_p,) with the jump at every place that fitted torques allow and other runs' torques tell apart.

    The fitted parameters come first; they are alone where no jump is in the model.
    """
    found = [solution.theta]
    ids = [q.id for q in solution.equations.parameters]
    for effect in [e for e in solution.effects if e.threshold]:
        sent = torques(others, effect)
        at = ids.index(effect.parameters[0].id)
        value = float(solution.theta[at])
        low, high = around(value, torques(fitted, effect))
        ends = np.concatenate(([low], sent[(sent > low) & (sent < high)], [high]))
        middles = [float(a + b) / 2 for a, b in itertools.pairwise(ends) if not a <= value <= b]
        for middle in sorted(middles, key=lambda d: abs(d - value))[:MOST]:
            moved = solution.theta.copy()
            moved[at] = middle
            found.append(moved)
    return tuple(found)
