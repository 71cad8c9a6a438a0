"""Stability of named effects over bags of runs: residuals and Jacobians at the optimum in, share of bags out.

A bag holds as many stretches as the fitted runs have, drawn with replacement (bagging, Breiman 1996). To first order
about the optimum, r(x + d) = r + J·d, every bag has the cost

    C(d) = Σ_b w_b·‖r_b + J_b·d‖² + λ·‖d‖²,  w_b how often stretch b was drawn.

d is in scaled unknowns, and λ, the residual's mean energy per independent row, keeps a parameter that a bag does not
determine within one of its scaled units: far away the first order says nothing.

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretches:
    """Residuals of one model with their derivatives, cut into stretches.

    Parameters
    ----------
    ids
        Ids of the parameters that the first columns belong to; further columns are initial states.
    slope
        Derivative of each of these parameters with respect to its scaled unknown, shape (n_ids,).
    values
        Values of all parameters at the optimum by id.
    residuals
        Residual over its standard deviation by stretch, shape (n_b,) each.
    jacobians
        Derivatives with respect to the scaled unknowns by stretch, shape (n_b, n) each.
    independent
        Number of independent rows of all stretches together.
    prior, prior_jacobian
        Residuals of priors, which every bag holds once, shapes (n_prior,) and (n_prior, n).
    """

    ids: tuple[str, ...]
    slope: Array
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
        parametrisation = solution.problem.parametrisation
        jacobians = [J.reshape(-1, n) for J in blocks.jacobians or ()]
        rows, derivatives = cut_runs([r.ravel() for r in blocks.rows], jacobians)
        return cls(
            ids=parametrisation.ids,
            slope=parametrisation.slope(solution.theta),
            values=solution.values,
            residuals=rows,
            jacobians=derivatives,
            independent=float(sum(r.size for r in rows)),
            prior=blocks.prior,
            prior_jacobian=blocks.prior_jacobian,
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
    moments = [_moments(r, J) for r, J in zip(stretches.residuals, stretches.jacobians, strict=True)]
    count = len(moments)
    draws = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), THRESHOLDS.verdict.bags)
    prior = _moments(stretches.prior, stretches.prior_jacobian)
    energy = sum(part.square for part in moments) / stretches.independent
    bags = [_Moments.sum_weighted([*moments, prior], np.append(weights, 1)) for weights in draws]
    shares = {}
    for effect in effects:
        amplitudes = {q.id for q in effect.parameters[: effect.amplitudes]}
        own = [k for k, id in enumerate(stretches.ids) if id in {q.id for q in effect.parameters}]
        moved = [k for k in own if stretches.ids[k] in amplitudes]
        if not moved:
            continue
        names = [stretches.ids[k] for k in moved]
        step = np.array([effect.neutral.get(id, 0.0) - stretches.values[id] for id in names]) / stretches.slope[moved]
        enough = len(own) * np.log(stretches.independent)
        gains = [_gain(bag, own, moved, step, energy, stretches.independent) for bag in bags]
        shares[effect.key] = float(np.mean([gain > enough for gain in gains]))
    return shares


@dataclass(frozen=True, slots=True)
class _Moments:
    """Moments JᵀJ, Jᵀr and rᵀr of a cost that is quadratic in the parameters."""

    normal: Array
    slope: Array
    square: float

    @classmethod
    def sum_weighted(cls, parts: Sequence[_Moments], weights: Array) -> _Moments:
        """Sum the moments of stretches."""
        pairs = [(part, float(weight)) for part, weight in zip(parts, weights, strict=True) if weight]
        return cls(
            sum(w * part.normal for part, w in pairs),  # type: ignore[arg-type] # sum begins at 0, and is an array
            sum(w * part.slope for part, w in pairs),  # type: ignore[arg-type] # the same
            sum(w * part.square for part, w in pairs),
        )

    def least(self, free: Sequence[int], damping: float) -> float:
        """Return the smallest cost over the parameters with the numbers ``free``, held by λ = ``damping``."""
        normal = self.normal[np.ix_(free, free)] + damping * np.eye(len(free))
        slope = self.slope[list(free)]
        return self.square - float(slope @ inverse(normal) @ slope)

    def move_to(self, columns: Sequence[int], step: Array) -> _Moments:
        """Return the cost about a point that lies ``step`` along some parameters away."""
        slope = self.slope + self.normal[:, list(columns)] @ step
        along = self.normal[np.ix_(columns, columns)]
        square = self.square + 2.0 * float(self.slope[list(columns)] @ step) + float(step @ along @ step)
        return _Moments(self.normal, slope, square)


def _moments(r: Array, J: Array) -> _Moments:
    return _Moments(J.T @ J, J.T @ r, float(r @ r))


def _gain(bag: _Moments, own: Sequence[int], moved: Sequence[int], step: Array, damping: float, n: float) -> float:
    """Return twice the gain in log score by an effect in one bag."""
    every = list(range(bag.slope.size))
    others = [k for k in every if k not in own]
    tiny = np.finfo(float).tiny
    with_effect = max(bag.least(every, damping), tiny)
    without = max(bag.move_to(moved, step).least(others, damping), tiny)
    return float(n * np.log(without / with_effect))
