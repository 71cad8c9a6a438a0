"""The same quantity measured in several tests: pooled and tested, disagreement shown.

Coefficients: the innovation y − A·π against (A·P·Aᵀ + R), χ² with as many degrees of freedom as coefficients. Joint
parameters fitted alone and again in a coupled test: d = a − b against V_a + V_b.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from haptid.identification.result.fit import Fit
from haptid.model.planning.inertial_belief import LinkBelief, Measurement
from haptid.support.linear_algebra import symmetric_inverse

DOUBT = 1e-3
"""Probability, after Bonferroni for the comparisons of one configuration, below which tests contradict each other."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """How a test agrees with those before it.

    Parameters
    ----------
    name
        ``joint 5: inertia and gravity``, ``Ks_0``.
    chi2, dof, p
        Statistic, degrees of freedom, and the probability of a larger one by chance.
    family
        Comparisons made together with this one.
    earlier, later, pooled
        Values of a single quantity where it is one; None otherwise.
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
        """Whether chance hardly explains the difference."""
        return self.p * self.family < DOUBT


def coefficients_agree(name: str, belief: LinkBelief, one: Measurement) -> Agreement | None:
    """Test a configuration's coefficients against the belief before it; None where it has none."""
    if not one.coefficients:
        return None
    mean, covariance = belief.predict(one.coefficients)
    total = covariance + one.covariance
    scale = np.sqrt(np.diag(total))
    d = (one.values - mean) / scale
    statistic = float(d @ symmetric_inverse(total / np.outer(scale, scale)) @ d)
    dof = len(d)
    return Agreement(name=name, chi2=statistic, dof=dof, p=float(chi2.sf(statistic, dof)))


def parameters_agree(earlier: Fit, later: Fit, suffix: str) -> tuple[Agreement, ...]:
    """Test parameters of a joint's own test against those of a coupled test, whose ids end in ``suffix``."""
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
    """Return one sentence on all tests."""
    if not agreements:
        return "No quantity was measured in more than one test."
    bad = [a.name for a in agreements if a.contradicts]
    if not bad:
        return f"{len(agreements)} comparisons between tests, none of which contradict each other."
    return f"{len(agreements)} comparisons between tests; contradicting each other: {', '.join(bad)}."
