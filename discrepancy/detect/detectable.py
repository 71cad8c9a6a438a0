"""How small an effect could be and still be seen in these runs: from the signatures alone, no simulation.

A signature of norm ‖D⊥‖ scaled by s gives T a non-central χ² distribution with s²·‖D⊥‖². The smallest detectable size
is the one whose T passes the threshold of the whole catalogue (p = `LEVEL` for the family) in `POWER` of all data sets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from haptid.discrepancy.detect.signatures import Point
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect

LEVEL, POWER = 0.01, 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class Detectable:
    """The smallest size of an entry's first parameter that would be seen, at the shape at which it shows best."""

    key: str
    parameter: str
    size: float
    unit: str

    def as_json(self) -> dict[str, object]:
        """Return the fields."""
        return {"id": self.key, "parameter": self.parameter, "value": self.size, "unit": self.unit}


@cache
def noncentrality(dof: int, tests: float) -> float:
    """Return λ at which T, χ² with ``dof`` and λ, passes the threshold of ``tests`` independent tests often enough.

    >>> round(noncentrality(1, 1.0), 2)
    14.88
    """
    threshold = float(chi2.isf(-np.expm1(np.log1p(-LEVEL) / tests), dof))
    return float(brentq(lambda x: ncx2.sf(threshold, dof, x) - POWER, 1e-3, 10.0 * threshold + 100.0))


def smallest(points: Sequence[Point], G: Array, tests: float, entries: Mapping[str, Effect]) -> tuple[Detectable, ...]:
    """Return the smallest detectable size of every entry, to first order, the others of its parameters being zero.

    Parameters
    ----------
    points
        Shapes that are visible at all.
    G
        Gram matrix of the projected, whitened signatures.
    tests
        Number of independent tests that the catalogue amounts to.
    """
    found: dict[str, Detectable] = {}
    for point in points:
        first = entries[point.key].parameters[0]
        column = point.columns.start
        power = noncentrality(len(point.values), tests)
        size = abs(point.values[0][first.id]) * float(np.sqrt(power / max(float(G[column, column]), 1e-300)))
        known = found.get(point.key)
        if known is None or size < known.size:
            found[point.key] = Detectable(key=point.key, parameter=first.id, size=size, unit=first.unit)
    return tuple(found[key] for key in sorted(found))
