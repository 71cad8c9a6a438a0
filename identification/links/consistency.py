"""Agreement of tests that measured the same quantity: fits and `LinkBelief` in, χ² tests (`Agreement`) out.

- Coefficients: χ² = dᵀ(A·P·Aᵀ + R)⁻¹d of the innovation d = y − A·π, with as many degrees of freedom as coefficients.
- Joint parameters fitted alone and again in a coupled test: χ² = (a − b)²/(V_a + V_b), with one degree of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from haptid.identification.result.fit import Fit
from haptid.identification.thresholds import THRESHOLDS
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.support.linear_algebra import symmetric_inverse


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """Comparison of a test with earlier ones.

    Parameters
    ----------
    name
        Quantity, such as ``joint 5: inertia and gravity`` or ``Ks_0``.
    chi2, dof, p
        Statistic, degrees of freedom, and p-value.
    family
        Number of comparisons of this configuration, for Bonferroni's correction.
    earlier, later, pooled
        Value and standard deviation of a single quantity in either test, and weighted by inverse variance; None for
        several coefficients.
    """

    name: str
    chi2: float
    dof: int
    p: float
    family: int = 1
    earlier: tuple[float, float] | None = None
    later: tuple[float, float] | None = None
    pooled: tuple[float, float] | None = None

    @property
    def contradicts(self) -> bool:
        """Whether the family-wise p-value is below `THRESHOLDS.least_p_of_consistent_tests`."""
        return self.p * self.family < THRESHOLDS.least_p_of_consistent_tests


def coefficients_agree(name: str, belief: LinkBelief, one: Measurement) -> Agreement | None:
    """Test the coefficients of a configuration against the belief from earlier tests.

    Parameters
    ----------
    name
        Name of the comparison.
    belief
        Belief over π before this configuration.
    one
        Measured coefficients of the configuration.

    Returns
    -------
    Agreement or None
        None where the configuration has no coefficients.
    """
    if not one.coefficients:
        return None
    mean, covariance = belief.predict(one.coefficients)
    total = covariance + one.covariance
    scale = np.sqrt(np.diag(total))
    # Scaled to standard deviations first: the cut of the pseudo-inverse must not depend on the coefficients' units.
    d = (one.values - mean) / scale
    statistic = float(d @ symmetric_inverse(total / np.outer(scale, scale)) @ d)
    dof = len(d)
    return Agreement(name=name, chi2=statistic, dof=dof, p=float(chi2.sf(statistic, dof)))


def parameters_agree(earlier: Fit, later: Fit, suffix: str) -> tuple[Agreement, ...]:
    """Test the parameters that two fits share.

    Parameters
    ----------
    earlier, later
        Fits of the same joint.
    suffix
        Ending of the joint's ids in the later fit, such as ``_0`` in a coupled test.

    Returns
    -------
    tuple of Agreement
        One comparison for every parameter that is free in both fits.
    """
    made = []
    for id in earlier.free:
        other = f"{id}{suffix}"
        if other in later.free:
            made.append(_one(other, _value(earlier, id), _value(later, other)))
    return tuple(made)


def _value(fit: Fit, id: str) -> tuple[float, float]:
    return fit.values[id], float(fit.std[fit.index(id)])


def _one(name: str, a: tuple[float, float], b: tuple[float, float]) -> Agreement:
    variance = a[1] ** 2 + b[1] ** 2
    statistic = (a[0] - b[0]) ** 2 / max(variance, 1e-300)
    weights = np.array([1.0 / max(a[1], 1e-300) ** 2, 1.0 / max(b[1], 1e-300) ** 2])
    pooled = float(weights @ [a[0], b[0]] / weights.sum()), float(1.0 / np.sqrt(weights.sum()))
    return Agreement(
        name=name, chi2=statistic, dof=1, p=float(chi2.sf(statistic, 1)), earlier=a, later=b, pooled=pooled
    )


def summary(agreements: Sequence[Agreement]) -> str:
    """Summarise the comparisons in one sentence.

    Parameters
    ----------
    agreements
        Comparisons of all configurations.

    Returns
    -------
    str
        Sentence with the number of comparisons and the names of the contradicting ones.
    """
    if not agreements:
        return "No quantity was measured in more than one test."
    bad = [a.name for a in agreements if a.contradicts]
    if not bad:
        return f"{len(agreements)} comparisons between tests, none of which contradict each other."
    return f"{len(agreements)} comparisons between tests; contradicting each other: {', '.join(bad)}."
