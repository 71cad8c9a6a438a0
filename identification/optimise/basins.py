"""Basins of a fit: the `Descent` of every start in, the minima that they share out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from haptid.identification.optimise.levenberg_marquardt import Descent
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Basin
from haptid.identification.thresholds import THRESHOLDS


def sort_into_basins(problem: Problem, descents: Sequence[Descent]) -> tuple[Basin, ...]:
    """Group the starts by the cost that they reached.

    Parameters
    ----------
    problem
        Problem that was minimised.
    descents
        Results of the starts, in the order of the starts.

    Returns
    -------
    tuple of Basin
        Minima, the best first; starts whose cost is not finite belong to none.

    Notes
    -----
    A start belongs to a basin where its cost exceeds the basin's smallest C by at most
    max(`THRESHOLDS.largest_cost_difference_in_basin`, `THRESHOLDS.largest_relative_cost_difference_in_basin`·C).
    """
    finite = [k for k, descent in enumerate(descents) if np.isfinite(descent.cost)]
    groups: list[list[int]] = []
    for k in sorted(finite, key=lambda k: (descents[k].cost, k)):
        smallest = descents[groups[-1][0]].cost if groups else -np.inf
        if descents[k].cost - smallest <= _tolerance(smallest):
            groups[-1].append(k)
        else:
            groups.append([k])
    basins = []
    for group in groups:
        best = descents[group[0]]
        basins.append(
            Basin(
                over_noise=float(np.sqrt(best.cost / problem.weight)),
                starts=tuple(sorted(group)),
                theta=problem.theta(best.x),
                simulations=sum(descents[k].calls for k in group) * len(problem.runs),
            )
        )
    return tuple(basins)


def _tolerance(cost: float) -> float:
    relative = THRESHOLDS.largest_relative_cost_difference_in_basin
    return max(THRESHOLDS.largest_cost_difference_in_basin, relative * cost)
