"""Profile likelihoods: `Problem`, minimum and `Curvature` in, 95 % `Interval` of every free parameter out.

With C(v) = min ‖r‖² over the other unknowns at p_k = v, the 95 % interval is where C(v) − C(p̂) ≤ f·χ²₁(0.95). The
factor f = V_kk/(H⁻¹)_kk, sandwich over plain curvature, accounts for time weights and correlation of the residuals
(Pace, Salvan & Sartori 2011): the interval is ±1.96 standard deviations where C is quadratic, and differs where it is
not.

1. Start 1.96 standard deviations from the minimum, along the direction in which a quadratic C would be lowest.
2. Minimise C over the other unknowns by Levenberg–Marquardt (`fit_pinned`).
3. Scale the distance by the root of the wanted over the found rise of C, and repeat until both agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.stats import chi2

from haptid.identification.optimise.levenberg_marquardt import Steps, Trial, cost_of, minimise, triangle_by_runs
from haptid.identification.problem.bounded_lsq import triangle
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.result.fit import Interval
from haptid.identification.statistics.covariance import Curvature
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.linear_algebra import inverse

LEVEL = float(chi2.ppf(0.95, 1))
"""95 % quantile of χ² with one degree of freedom [squares over the noise]."""


def profiles(problem: Problem, x: Array, bent: Curvature) -> dict[str, Interval]:
    """Compute the 95 % interval of every free parameter by its profile likelihood.

    Parameters
    ----------
    problem
        Problem that was minimised.
    x
        Minimum, shape (n,).
    bent
        Curvature at the minimum.

    Returns
    -------
    dict of Interval
        Interval in the parameter's unit by id; an end is None where a bound comes first, where a simulation is not
        finite, or where `THRESHOLDS.most_distances_of_profile` distances do not reach it.
    """
    plain = inverse(bent.hessian)
    walk = _Walk(problem=problem, x=x, cost=cost_of(problem.blocks(x)))
    intervals = {}
    for k, id in enumerate(problem.parametrisation.ids):
        width, direction = float(np.sqrt(max(bent.covariance[k, k], 1e-300))), plain[:, k] / plain[k, k]
        target = LEVEL * bent.covariance[k, k] / plain[k, k]
        ends = [walk.end(k, direction, sign * width, float(target)) for sign in (-1.0, 1.0)]
        intervals[id] = Interval(lower=ends[0], upper=ends[1])
    return intervals


@dataclass(frozen=True, slots=True, kw_only=True)
class _Walk:
    """Search for the ends of intervals from the minimum x (n,), where the cost is ``cost``."""

    problem: Problem
    x: Array
    cost: float

    def end(self, k: int, direction: Array, width: float, target: float) -> float | None:
        """Find the value of a parameter at which the cost has risen by a wanted amount.

        Parameters
        ----------
        k
            Index of the parameter.
        direction
            Direction in which a quadratic cost is lowest at a given value of the parameter, shape (n,); entry k is 1.
        width
            Scaled standard deviation of the parameter, negative for the lower end.
        target
            Wanted rise of the cost [squares over the noise].

        Returns
        -------
        float or None
            Value in the parameter's unit; None where no end is found.
        """
        low, high = (float(b[k]) for b in self.problem.parametrisation.bounds)
        room = (high if width > 0 else low) - float(self.x[k])
        distance, at, start = np.sqrt(LEVEL) * width, 0.0, self.x
        for _ in range(THRESHOLDS.most_distances_of_profile):
            distance = np.sign(width) * min(abs(distance), abs(room))
            moved, cost = fit_pinned(self.problem, start + direction * (distance - at), k)
            if not np.isfinite(cost):
                return None
            share = float(np.sqrt(max(cost - self.cost, 0.0) / target))
            if abs(share - 1.0) < THRESHOLDS.largest_error_of_root_rise:
                return float(self.problem.theta(moved)[self.problem.parametrisation.free[k]])
            if share < 1.0 and abs(distance) >= abs(room):
                return None
            start, at = moved, distance
            # Where C is quadratic, its root is proportional to the distance; the clip bounds a step where it is not.
            distance /= float(np.clip(share, 0.4, 2.5))
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pinned:
    """The cost ‖r‖² over all unknowns but the one at ``k``, which keeps its value in x (n,); satisfies `Cost`."""

    problem: Problem
    x: Array
    k: int

    def with_others(self, others: Array) -> Array:
        """Return all unknowns (n,) of the others (n − 1,)."""
        return np.insert(others, self.k, self.x[self.k])

    def at(self, others: Array) -> Trial:
        blocks = self.problem.blocks(self.with_others(others))
        return Trial(cost=cost_of(blocks), excess=0.0, triangle=partial(self._triangle, blocks))

    def _triangle(self, blocks: Blocks) -> tuple[Array, Array]:
        R, c = triangle_by_runs(blocks)
        return triangle(np.delete(R, self.k, axis=1), -c)

    def constraints(self, others: Array) -> tuple[Array, Array]:
        A, b = self.problem.constraints()
        return np.delete(A, self.k, axis=1), np.minimum(b - A @ self.with_others(others), 0.0)

    def move(self, others: Array, d: Array) -> Array:
        # Straight: along the valley of a spring the unknown that is held could move with another.
        return others + d


def fit_pinned(problem: Problem, x: Array, k: int) -> tuple[Array, float]:
    """Minimise ‖r‖² over all unknowns but one.

    Parameters
    ----------
    problem
        Problem with residuals r(x).
    x
        First unknowns, shape (n,).
    k
        Index of the unknown that keeps its value.

    Returns
    -------
    x : ndarray, shape (n,)
        Minimum.
    cost : float
        ‖r‖² there [squares over the noise]; infinite where the first simulation is not finite.
    """
    pinned = _Pinned(problem=problem, x=_within(problem, x, k), k=k)
    most = THRESHOLDS.most_simulations_of_profile
    steps = Steps(damping=THRESHOLDS.least_damping)
    best = minimise(pinned, np.delete(pinned.x, k), iterations=most, tolerance=1e-3, steps=steps)
    return pinned.with_others(best.x), best.cost


def _within(problem: Problem, x: Array, k: int) -> Array:
    """Move all parameters but the one at ``k`` into their bounds."""
    low, high = problem.parametrisation.bounds
    n, kept = problem.n_parameters, x[k]
    moved = x.copy()
    moved[:n] = np.clip(x[:n], low, high)
    moved[k] = kept
    return moved
