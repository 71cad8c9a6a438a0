"""Which starts ended in the same minimum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.optimise.levenberg_marquardt import Descent
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Basin

SAME = 2.0
"""Costs (sums of squares over the noise) this close belong to one minimum: far below what tells two models apart."""


def sort_into_basins(problem: Problem, descents: Sequence[Descent]) -> tuple[Basin, ...]:
    """Return the minima, the best first; a start whose simulation left the finite numbers is in none."""
    order = sorted((k for k, d in enumerate(descents) if np.isfinite(d.cost)), key=lambda k: (descents[k].cost, k))
    groups: list[list[int]] = []
    for k in order:
        if groups and descents[k].cost - descents[groups[-1][0]].cost <= _tolerance(descents[groups[-1][0]].cost):
            groups[-1].append(k)
        else:
            groups.append([k])
    return tuple(
        Basin(
            over_noise=float(np.sqrt(descents[group[0]].cost / problem.weight)),
            starts=tuple(sorted(group)),
            theta=problem.theta(descents[group[0]].x),
            simulations=sum(descents[k].calls for k in group) * len(problem.runs),
        )
        for group in groups
    )


def _tolerance(cost: float) -> float:
    return max(SAME, 1e-3 * cost)
