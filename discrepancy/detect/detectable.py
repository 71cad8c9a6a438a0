"""Compute the smallest detectable size of every catalogue effect: signatures in, `Detectable`s out.

A signature of norm ‖D⊥‖ scaled by s gives the score statistic T a non-central χ² distribution with the non-centrality
s²·‖D⊥‖². The smallest detectable size is the one whose T passes the threshold of the whole catalogue (family-wise
p-value `detected_family_wise_p_value`) in the share `detection_power` of all data sets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from haptid.discrepancy.detect.signatures import Point
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect


@dataclass(frozen=True, slots=True, kw_only=True)
class Detectable:
    """The smallest detectable size of a catalogue effect, at the shape where it is seen best.

    Parameters
    ----------
    key
        Key of the effect.
    parameter
        Id of its first parameter, which is an amplitude.
    size
        Smallest detectable magnitude of that parameter, in ``unit``.
    unit
        Unit of the parameter.
    """

    key: str
    parameter: str
    size: float
    unit: str

    def as_json(self) -> dict[str, object]:
        """Convert to an entry of ``smallest_detectable`` in the finding's JSON.

        Returns
        -------
        dict
            ``id`` (key of the effect), ``parameter``, ``value`` in ``unit``, ``unit``.
        """
        return {"id": self.key, "parameter": self.parameter, "value": self.size, "unit": self.unit}


@cache
def noncentrality(dof: int, tests: float) -> float:
    """Return the non-centrality λ at which the score statistic passes its threshold in a share of data sets.

    Parameters
    ----------
    dof
        Degrees of freedom of the statistic T.
    tests
        Number of independent tests N of the catalogue; each has the level 1 − (1 − p)^(1/N), with p the
        family-wise `detected_family_wise_p_value`.

    Returns
    -------
    float
        λ.

    Examples
    --------
    >>> round(noncentrality(1, 1.0), 2)
    14.88
    """
    threshold = float(chi2.isf(-np.expm1(np.log1p(-THRESHOLDS.detect.detected_family_wise_p_value) / tests), dof))

    def excess_power(noncentrality: float) -> float:
        return float(ncx2.sf(threshold, dof, noncentrality)) - THRESHOLDS.detect.detection_power

    return float(brentq(excess_power, 1e-3, 10.0 * threshold + 100.0))


def smallest(
    points: Sequence[Point], G: Array, tests: float, catalogue: Mapping[str, Effect]
) -> tuple[Detectable, ...]:
    """Return the smallest detectable size of every catalogue effect, to first order, its other amplitudes being zero.

    Parameters
    ----------
    points
        Shapes whose signature survives the projection.
    G
        Gram matrix of the projected, whitened signatures, shape (n_columns, n_columns).
    tests
        Number of independent tests of the catalogue.
    catalogue
        Catalogue effects by key, in SI units.

    Returns
    -------
    tuple of Detectable
        One for every effect with such a shape, sorted by key.
    """
    found: dict[str, Detectable] = {}
    for point in points:
        first = catalogue[point.key].parameters[0]
        # The first column is that of the first amplitude, the size that is reported.
        column = point.columns.start
        power = noncentrality(len(point.values), tests)
        size = abs(point.values[0][first.id]) * float(np.sqrt(power / max(float(G[column, column]), 1e-300)))
        known = found.get(point.key)
        if known is None or size < known.size:
            found[point.key] = Detectable(key=point.key, parameter=first.id, size=size, unit=first.unit)
    return tuple(found[key] for key in sorted(found))
