"""Stability of named effects over bags of runs: residuals and Jacobians at the optimum in, share of bags out.

A bag holds as many stretches as the fitted runs have, drawn with replacement (bagging, Breiman 1996). To first order
about the optimum, r(x + d) = r + J·d, every bag has the cost

    C(d) = Σ_b w_b·‖r_b + J_b·d‖²,  w_b how often stretch b was drawn.

1. Minimise C over all parameters.
2. Minimise C with the effect's amplitudes at their neutral values and its shapes held: the model without the effect.
3. The effect keeps its name in the bag where n·ln(C₂/C₁) > k·ln n, with n independent rows and k parameters of the
   effect: the bag's own BIC.

Few stretches carry an effect whose share of bags is small.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.discrepancy.fit.solution import Solution
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.model.effects.effect import Effect
from haptid.support.linear_algebra import inverse

LEAST_CURVATURE = 1e-10
"""Curvature that every parameter has in every bag, over its curvature in all runs [1]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretches:
    """Residuals of one model with their derivatives, cut into stretches.

    Parameters
    ----------
    ids
        Ids of the parameters that the first columns belong to; further columns are initial states.
    values
        Values of all parameters at the optimum by id.
    residuals
        Residual over its standard deviation by stretch, shape (n_b,) each.
    jacobians
        Derivatives with respect to the parameters in their own units and to the initial states, shape (n_b, n) each.
    independent
        Number of independent rows of all stretches together.
    prior, prior_jacobian
        Residuals of priors, which every bag holds once, shapes (n_prior,) and (n_prior, n).
    """

    ids: tuple[str, ...]
    values: Mapping[str, float]
    residuals: tuple[Array, ...]
    jacobians: tuple[Array, ...]
    independent: float
    prior: Array
    prior_jacobian: Array

    @classmethod
    def of(cls, solution: Solution) -> Stretches:
        """Cut the fitted runs of a solution, whose whitened rows are all independent.

        Parameters
        ----------
        solution
            Fitted model.

        Returns
        -------
        Stretches
        """
        blocks, n = solution.blocks, solution.blocks.prior_jacobian.shape[1]
        scale = np.ones(n)
        parametrisation = solution.problem.parametrisation
        scale[: len(parametrisation.free)] = 1.0 / parametrisation.slope(solution.theta)
        jacobians = [J.reshape(-1, n) * scale for J in blocks.jacobians or ()]
        rows, derivatives = cut_runs([r.ravel() for r in blocks.rows], jacobians)
        return cls(
            ids=parametrisation.ids,
            values=solution.values,
            residuals=rows,
            jacobians=derivatives,
            independent=float(sum(r.size for r in rows)),
            prior=blocks.prior,
            prior_jacobian=blocks.prior_jacobian * scale,
        )


def cut_runs(residuals: Sequence[Array], jacobians: Sequence[Array]) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Cut every run into equally many stretches.

    Parameters
    ----------
    residuals, jacobians
        By run, shapes (n_t,) and (n_t, n).

    Returns
    -------
    residuals, jacobians
        By stretch; at least `THRESHOLDS.verdict.least_stretches_of_bag` stretches of all runs together.
    """
    count = -(-THRESHOLDS.verdict.least_stretches_of_bag // len(residuals))
    rows, derivatives = [], []
    for r, J in zip(residuals, jacobians, strict=True):
        rows += np.array_split(r, count)
        derivatives += np.array_split(J, count)
    return tuple(rows), tuple(derivatives)


def stability_of(stretches: Stretches, effects: Sequence[Effect], *, seed: int = 0) -> dict[str, float]:
    """Compute the share of bags in which each effect keeps its name.

    Parameters
    ----------
    stretches
        The model with all effects.
    effects
        Its effects, in SI units.
    seed
        Seed of the bags.

    Returns
    -------
    dict
        Share [1] by key of the effect; effects without a fitted amplitude are left out.
    """
    size = np.sqrt(sum(np.sum(J**2, axis=0) for J in stretches.jacobians))
    size = np.where(size > 0, size, 1.0)
    moments = [_moments(r, J / size) for r, J in zip(stretches.residuals, stretches.jacobians, strict=True)]
    count = len(moments)
    draws = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), THRESHOLDS.verdict.bags)
    prior = _moments(stretches.prior, stretches.prior_jacobian / size)
    bags = [_Moments.weighted([*moments, prior], np.append(weights, 1)) for weights in draws]
    shares = {}
    for effect in effects:
        amplitudes = {q.id for q in effect.parameters[: effect.amplitudes]}
        own = [k for k, id in enumerate(stretches.ids) if id in {q.id for q in effect.parameters}]
        moved = [k for k in own if stretches.ids[k] in amplitudes]
        if not moved:
            continue
        neutral = np.array(
            [effect.neutral.get(stretches.ids[k], 0.0) - stretches.values[stretches.ids[k]] for k in moved]
        )
        enough = len(own) * np.log(stretches.independent)
        gains = [_gain(bag, own, moved, neutral * size[moved], stretches.independent) for bag in bags]
        shares[effect.key] = float(np.mean([gain > enough for gain in gains]))
    return shares


@dataclass(frozen=True, slots=True)
class _Moments:
    """Moments JᵀJ, Jᵀr and rᵀr of a cost that is quadratic in the parameters."""

    normal: Array
    slope: Array
    square: float

    @classmethod
    def weighted(cls, parts: Sequence[_Moments], weights: Array) -> _Moments:
        """Sum the moments of stretches."""
        pairs = [(part, float(weight)) for part, weight in zip(parts, weights, strict=True) if weight]
        return cls(
            sum(w * part.normal for part, w in pairs),  # type: ignore[arg-type] # sum begins at 0, and is an array
            sum(w * part.slope for part, w in pairs),  # type: ignore[arg-type] # the same
            sum(w * part.square for part, w in pairs),
        )

    def least(self, free: Sequence[int]) -> float:
        """Return the smallest cost over the parameters with the numbers ``free``."""
        # A run that was not drawn says nothing on its initial state: the floor keeps the matrix regular.
        normal = self.normal[np.ix_(free, free)] + LEAST_CURVATURE * np.eye(len(free))
        slope = self.slope[list(free)]
        return self.square - float(slope @ inverse(normal) @ slope)

    def moved(self, columns: Sequence[int], step: Array) -> _Moments:
        """Return the cost about a point that lies ``step`` along some parameters away."""
        slope = self.slope + self.normal[:, list(columns)] @ step
        along = self.normal[np.ix_(columns, columns)]
        square = self.square + 2.0 * float(self.slope[list(columns)] @ step) + float(step @ along @ step)
        return _Moments(self.normal, slope, square)


def _moments(r: Array, J: Array) -> _Moments:
    return _Moments(J.T @ J, J.T @ r, float(r @ r))


def _gain(bag: _Moments, own: Sequence[int], moved: Sequence[int], step: Array, n: float) -> float:
    """Return twice the gain in log score by an effect in one bag."""
    every = list(range(bag.slope.size))
    others = [k for k in every if k not in own]
    tiny = np.finfo(float).tiny
    with_effect = max(bag.least(every), tiny)
    without = max(bag.moved(moved, step).least(others), tiny)
    return float(n * np.log(without / with_effect))
