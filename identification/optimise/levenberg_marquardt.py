"""Levenberg–Marquardt under bounds and orderings: `Cost` and first unknowns in, `Descent` out.

1. Expand the cost at x to second order, as a triangular system R, c (`Trial.triangle`).
2. Solve min ‖R·d − c‖² + λ·‖D·d‖² under bounds and orderings, D the norms of R's columns.
3. Stop where the predicted decrease is below the tolerance, also without damping, or where progress has stalled.
4. Move x along d and simulate.
5. Accept the step where the cost falls by a share of the prediction, and set λ by the gain ratio; else raise λ.

The cost of a fit is `SumOfSquares`, ‖r‖² of a `Problem`: R and c reduce its Jacobian and residual.

Damping in the scale of the columns is Marquardt's (1963); the update of λ by the gain ratio is Nielsen's (1999). A
step of length 1 along an unknown costs a small share of the tolerance besides
(`THRESHOLDS.share_of_tolerance_for_unit_step`): long valleys (gravity and spring) are followed to their minimum, and
rounding does not decide where an unknown goes that the residual does not see.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from haptid.identification.problem.bounded_lsq import step_within, triangle
from haptid.identification.problem.residuals import Blocks, Problem
from haptid.identification.problem.retraction import Retraction
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array

Simulated = Callable[[int, float], None]
"""Function that is told the number of simulations of all runs so far, and the smallest cost [squares over noise]."""


def ignore_simulation(calls: int, cost: float) -> None:
    """Take how far a minimiser is, and do nothing.

    Parameters
    ----------
    calls
        Number of simulations of all runs.
    cost
        Smallest cost so far [squares over the noise].
    """


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """Result of a minimiser.

    Parameters
    ----------
    x
        Unknowns with the smallest cost, shape (n,).
    cost
        Cost ‖r‖² [squares over the noise].
    calls
        Number of simulations of all runs.
    converged
        Whether the minimiser met its tolerance.
    """

    x: Array
    cost: float
    calls: int
    converged: bool

    @classmethod
    def at(cls, x: Array) -> Descent:
        """Return a descent that has not yet begun.

        Parameters
        ----------
        x
            First unknowns, shape (n,).

        Returns
        -------
        Descent
            Without simulations; its cost is infinite.
        """
        return cls(x=x, cost=float("inf"), calls=0, converged=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Steps:
    """How long the steps of a descent are.

    Parameters
    ----------
    damping
        Damping λ of the first step [1].
    longest
        Longest step along each unknown, shape (n,), infinite where it has none; None where no unknown has one.
    """

    damping: float = 1e-3
    longest: Array | None = None

    @classmethod
    def short(cls, problem: Problem, damping: float = 1e-3) -> Steps:
        """Return steps that move no logarithm by more than `THRESHOLDS.longest_step_of_logarithm`.

        Parameters
        ----------
        problem
            Problem whose parameters they move.
        damping
            Damping λ of the first step [1].

        Returns
        -------
        Steps
        """
        longest = np.full(problem.size, np.inf)
        longest[np.flatnonzero(problem.parametrisation.log)] = THRESHOLDS.longest_step_of_logarithm
        return cls(damping=damping, longest=longest)


FREE_STEPS = Steps()
"""Where nothing is known of the way."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """Cost at trial unknowns x.

    Parameters
    ----------
    cost
        Cost C(x) [squares over the noise]; infinite where a simulation is not finite.
    excess
        What C(x) exceeds that of noise alone by [squares over the noise]; 0 where nobody knows what noise leaves.
    triangle
        Function that returns a triangular R (n, n) and c (n,) with C(x + d) ≈ C(x) − ‖c‖² + ‖R·d − c‖²; it is called
        where x is accepted.
    """

    cost: float
    excess: float
    triangle: Callable[[], tuple[Array, Array]]


class Cost(Protocol):
    """A cost that Levenberg–Marquardt lowers."""

    def at(self, x: Array) -> Trial:
        """Compute the cost.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        Trial
        """

    def constraints(self, x: Array) -> tuple[Array, Array]:
        """Write bounds and orderings as linear inequalities A·d ≥ slack of a step d.

        Parameters
        ----------
        x
            Unknowns, shape (n,).

        Returns
        -------
        A : ndarray, shape (n_c, n)
            Coefficients.
        slack : ndarray, shape (n_c,)
            Limits, none above 0.
        """

    def move(self, x: Array, d: Array) -> Array:
        """Move the unknowns along a step.

        Parameters
        ----------
        x, d
            Unknowns and step, shape (n,).

        Returns
        -------
        ndarray, shape (n,)
            x + d to first order.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class SumOfSquares:
    """The cost ‖r(x)‖² of a problem under an observer gain.

    Parameters
    ----------
    problem
        Problem with residuals r(x).
    gain
        Observer gain L [1/s].
    along
        Moves the unknowns along the valleys of springs.
    """

    problem: Problem
    gain: float
    along: Retraction

    @classmethod
    def of(cls, problem: Problem, gain: float = 0.0) -> SumOfSquares:
        """Return the cost of a problem.

        Parameters
        ----------
        problem
            Problem with residuals r(x).
        gain
            Observer gain L [1/s]; 0 simulates freely.

        Returns
        -------
        SumOfSquares
        """
        return cls(problem=problem, gain=gain, along=Retraction.of(problem))

    def at(self, x: Array) -> Trial:
        """See `Cost`; all runs are simulated with sensitivities."""
        blocks = self.problem.blocks(x, self.gain)
        cost = cost_of(blocks)
        return Trial(cost=cost, excess=cost - blocks.residual.size, triangle=partial(triangle_by_runs, blocks))

    def constraints(self, x: Array) -> tuple[Array, Array]:
        """See `Cost`."""
        return self.along.constraints(x)

    def move(self, x: Array, d: Array) -> Array:
        """See `Cost`; springs move along their valleys."""
        return self.along.move(x, d)


def minimise(
    objective: Cost,
    x: Array,
    *,
    iterations: int = 40,
    tolerance: float = 0.01,
    relative: float = 0.0,
    steps: Steps = FREE_STEPS,
    tell: Simulated = ignore_simulation,
) -> Descent:
    """Minimise a cost under bounds and orderings by Levenberg–Marquardt steps.

    Parameters
    ----------
    objective
        The cost, such as the `SumOfSquares` of a problem.
    x
        First unknowns, shape (n,).
    iterations
        Largest number of simulations of all runs.
    tolerance
        Predicted decrease of the cost below which the minimiser stops [squares over the noise]; it grows where the
        residual is far above the noise (`THRESHOLDS.excess_cost_at_full_tolerance`).
    relative
        The same as a share of the cost; the larger of both counts.
    steps
        How long the steps are.
    tell
        Told after each simulation of all runs.

    Returns
    -------
    Descent
        Its cost is infinite, with x unchanged, where the first simulation is not finite.

    Notes
    -----
    The minimiser also stops where `THRESHOLDS.most_simulations_without_progress` successive simulations decrease the
    cost by less than the tolerance each, on average. Along a narrow valley the predicted decrease of a damped step is
    small however far the minimum is: before the minimiser stops, the predicted decrease of the step with the damping
    `THRESHOLDS.least_damping` must be small as well; otherwise that step is tried. So must be that of a step that is
    not shortened by ``steps.longest``.
    """
    now = objective.at(x)
    size, growth, calls, converged, freed = steps.damping, 2.0, 1, False, False
    if not np.isfinite(now.cost):
        return Descent(x=x, cost=now.cost, calls=calls, converged=False)
    R, c = now.triangle()
    costs = [now.cost]
    while calls < iterations:
        limits = objective.constraints(x)
        near = _shortened(limits, steps.longest)
        excess = now.excess / THRESHOLDS.excess_cost_at_full_tolerance
        enough = max(tolerance * max(1.0, excess), relative * now.cost)
        d, predicted = _step(R, c, size, enough, *near)
        # A small prediction may be the damping's doing: the undamped step decides, once for every accepted point.
        if predicted <= enough and not freed:
            freed, size = True, THRESHOLDS.least_damping
            d, predicted = _step(R, c, size, enough, *near)
        # With damping above 1, or where the step was shortened, a small prediction says nothing of the minimum.
        small = predicted <= enough and size < 1.0
        if small and steps.longest is not None:
            small = _step(R, c, size, enough, *limits)[1] <= enough
        converged = small or _stalls(costs, enough)
        if converged or size > THRESHOLDS.largest_damping:
            break
        moved = objective.move(x, d)
        trial = objective.at(moved)
        calls += 1
        ratio = (now.cost - trial.cost) / max(predicted, 1e-12) if np.isfinite(trial.cost) else -1.0
        if ratio > THRESHOLDS.least_actual_over_predicted_decrease:
            x, now, growth, freed = moved, trial, 2.0, False
            R, c = now.triangle()
            size = max(size * max(0.1, 1.0 - (2.0 * ratio - 1.0) ** 3), THRESHOLDS.least_damping)
        else:
            # From 1e-6 upwards: a rejected undamped step would take many more simulations to become shorter.
            size, growth = max(size, 1e-6) * growth, 2.0 * growth
        costs.append(now.cost)
        tell(calls, now.cost)
    return Descent(x=x, cost=now.cost, calls=calls, converged=converged)


@dataclass(frozen=True, slots=True, kw_only=True)
class Foreseen:
    """What one step from some unknowns promises.

    Parameters
    ----------
    cost
        Cost there [squares over the noise].
    predicted
        Decrease that the linear model predicts for the step [squares over the noise].
    seen
        Norms of the columns of the Jacobian, shape (n,): change of the residual for each unknown.
    """

    cost: float
    predicted: float
    seen: Array


def foresee(objective: Cost, x: Array, steps: Steps) -> Foreseen | None:
    """Predict what one step lowers the cost by.

    Parameters
    ----------
    objective
        The cost.
    x
        Unknowns, shape (n,).
    steps
        How long the step may be.

    Returns
    -------
    Foreseen or None
        None where the simulation is not finite.
    """
    now = objective.at(x)
    if not np.isfinite(now.cost):
        return None
    R, c = now.triangle()
    _, predicted = _step(R, c, steps.damping, 0.0, *_shortened(objective.constraints(x), steps.longest))
    return Foreseen(cost=now.cost, predicted=predicted, seen=np.linalg.norm(R, axis=0))


def _stalls(costs: list[float], enough: float) -> bool:
    """Return whether the latest simulations decreased the cost by less than ``enough`` each, on average."""
    count = THRESHOLDS.most_simulations_without_progress
    return len(costs) > count and costs[-count - 1] - costs[-1] < count * enough


def cost_of(blocks: Blocks) -> float:
    """Compute the cost ‖r‖².

    Parameters
    ----------
    blocks
        Residuals of the runs and of the priors.

    Returns
    -------
    float
        Cost [squares over the noise]; infinite where a residual or a derivative is not a finite number.
    """
    r = blocks.residual
    finite = np.isfinite(r).all() and all(np.isfinite(J).all() for J in blocks.jacobians or ())
    return float(r @ r) if finite else float("inf")


def triangle_by_runs(blocks: Blocks) -> tuple[Array, Array]:
    """Reduce all residuals to triangular form, by a QR decomposition of each run and one of the results.

    Parameters
    ----------
    blocks
        Residuals and Jacobians of the runs and of the priors.

    Returns
    -------
    R : ndarray, shape (n, n)
        Upper triangular matrix with RᵀR = JᵀJ over all rows.
    c : ndarray, shape (n,)
        Right-hand side, as in `triangle`.

    References
    ----------
    Golub & Van Loan, Matrix Computations, 2013, section 5.2.
    """
    parts, targets = [blocks.prior_jacobian], [blocks.prior]
    for J, r in zip(blocks.jacobians or (), blocks.rows, strict=True):
        flat = J.reshape(-1, J.shape[-1])
        # A run's rows do not depend on the initial states of the other runs: its QR leaves those columns out.
        moved = np.flatnonzero(flat.any(axis=0))
        R, c = triangle(flat[:, moved], r.ravel())
        part = np.zeros((moved.size, flat.shape[1]))
        part[:, moved] = R
        parts.append(part)
        targets.append(-c)
    return triangle(np.concatenate(parts), np.concatenate(targets))


def _shortened(limits: tuple[Array, Array], longest: Array | None) -> tuple[Array, Array]:
    """Add to the inequalities of a step how long it may be along each unknown."""
    if longest is None:
        return limits
    A, slack = limits
    bound = np.flatnonzero(np.isfinite(longest))
    along = np.eye(longest.size)[bound]
    return np.vstack((A, along, -along)), np.concatenate((slack, -longest[bound], -longest[bound]))


def _step(R: Array, c: Array, damping: float, enough: float, A: Array, slack: Array) -> tuple[Array, float]:
    """Return the step and the decrease of the cost that the linear model predicts for it.

    A decrease below ``enough`` ends the descent.
    """
    # The columns of R have the norms of the Jacobian's; the floor keeps the system regular where a column is 0.
    columns = np.maximum(np.linalg.norm(R, axis=0), 1e-12 * max(float(np.abs(R).max()), 1e-300))
    held = np.hypot(np.sqrt(damping) * columns, np.sqrt(THRESHOLDS.share_of_tolerance_for_unit_step * enough))
    damped, target = triangle(np.vstack((R, np.diag(held))), -np.concatenate((c, np.zeros_like(c))))
    d = step_within(damped, target, A, np.minimum(slack, 0.0))
    left = c - R @ d
    return d, float(c @ c - left @ left)
