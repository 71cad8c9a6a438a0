"""One cost for torque and position: a `Fit` of the torque in, the same fit moved along what the position sees out.

The torque tells inertia and friction row by row, but a constant torque and the level of dry friction only to the errors
of the model. A free simulation integrates what these are off by: a share of a per cent is a drift of millimetres. So
the position may move the estimate within the errors of the torque,

    (θ − θ̂)ᵀ·C⁻¹·(θ − θ̂) + Σ_runs n·mean(e²)/s²,

θ̂ and C the estimate by torque and its covariance, e the error of a free simulation from the measured start, s its RMS
at the estimate, and n the run's number of correlation lengths of e, of which a drift has few. Fitted runs count alone.
Inertia, gravity, spring, Coulomb and viscous friction move; stiction keeps its ratio to Coulomb friction, and all that
is seen at reversals alone stays. A Gauss-Newton step that does not lower the cost is halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.identification.baseline.delay import with_delayed_torque
from haptid.identification.baseline.least_squares import correlation_length
from haptid.identification.problem.parametrisation import Parametrisation
from haptid.identification.result.fit import Fit
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import inverse, rms

RIGID = ("inertia", "gravity_cos", "gravity_sin", "Ks")
"""Parameters of the joint, besides friction, that the position may move."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moved:
    """An estimate that holds torque and position.

    Parameters
    ----------
    theta
        Parameters, shape (n_p,).
    before, after
        RMS error of free simulations of the fitted runs [rad], or [m] of a prismatic joint, by the torque alone and at
        these parameters.
    """

    theta: Array
    before: float
    after: float


def move_by_position(found: Fit, simulator: Simulator, runs: Sequence[Run], delay: float) -> Moved | None:
    """Move the estimate of a torque fit along what free simulations of the fitted runs see.

    Parameters
    ----------
    found
        Fit of the torque of a single joint, with the errors of its parameters.
    simulator
        Simulator from torque to position, of the same parameters.
    runs
        Runs as recorded.
    delay
        Delay of the recorded torque [s].

    Returns
    -------
    Moved or None
        None where a free simulation leaves the motion, or where nothing moves.
    """
    driven = [with_delayed_torque(run, delay) for run in runs if run.use == "fit"]
    roles = law_named(found.equations.friction[0]).roles
    moved = [id for id in (*RIGID, roles.coulomb, roles.viscous) if id in found.free]
    places = [found.free.index(id) for id in moved]
    covariance = found.covariance[np.ix_(places, places)]
    if not moved or np.any(np.diag(covariance) <= 0.0):
        return None
    information = inverse(covariance)
    ids = [q.id for q in found.equations.parameters]
    columns = [ids.index(id) for id in moved]
    errors, slopes = _simulate(simulator, found.theta, driven, columns)
    motion = np.sqrt(np.mean([np.var(run.y) for run in driven]))
    size = rms(np.concatenate(errors))
    if not size <= THRESHOLDS.largest_free_residual_over_motion * motion:
        return None
    cost = _JointCost(
        found=found,
        simulator=simulator,
        runs=driven,
        columns=columns,
        information=information,
        weights=[1.0 / (correlation_length(e) * size**2) for e in errors],
    )
    reached = _minimise(cost, cost.point(found.theta, errors, slopes))
    after = rms(np.concatenate(reached.errors))
    return Moved(theta=reached.theta, before=size, after=after) if after < size else None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Point:
    """Parameters (n_p,) with the errors of the free simulations there, their slopes by run, and the cost [1]."""

    theta: Array
    errors: Sequence[Array]
    slopes: Sequence[Array]
    cost: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _JointCost:
    """The cost of torque and position over the parameters in ``columns``, with one weight a run."""

    found: Fit
    simulator: Simulator
    runs: Sequence[Run]
    columns: Sequence[int]
    information: Array
    weights: Sequence[float]

    def at(self, theta: Array) -> _Point:
        """Simulate the runs, and evaluate the cost."""
        return self.point(theta, *_simulate(self.simulator, theta, self.runs, self.columns))

    def point(self, theta: Array, errors: Sequence[Array], slopes: Sequence[Array]) -> _Point:
        """Evaluate the cost where the runs are simulated already; it is infinite where they are not finite."""
        step = theta[self.columns] - self.found.theta[self.columns]
        seen = sum(weight * float(e @ e) for weight, e in zip(self.weights, errors, strict=True))
        cost = float(step @ self.information @ step) + seen if np.isfinite(seen) else np.inf
        return _Point(theta=theta, errors=errors, slopes=slopes, cost=cost)

    def step_from(self, point: _Point) -> Array:
        """Return the Gauss-Newton step, shape (n_columns,)."""
        H = self.information.copy()
        g = self.information @ (self.found.theta[self.columns] - point.theta[self.columns])
        for weight, e, J in zip(self.weights, point.errors, point.slopes, strict=True):
            H, g = H + weight * J.T @ J, g + weight * J.T @ e
        return np.asarray(inverse(H) @ g)


def _minimise(cost: _JointCost, start: _Point) -> _Point:
    """Follow Gauss-Newton steps; one that does not lower the cost is halved."""
    best, length = start, 1.0
    for _ in range(THRESHOLDS.most_simulations_of_refit):
        trial = cost.at(_move(cost.found, best.theta, cost.columns, length * cost.step_from(best)))
        if trial.cost >= best.cost:
            length *= 0.5
            continue
        decrease = best.cost - trial.cost
        best, length = trial, min(2.0 * length, 1.0)
        if decrease < THRESHOLDS.least_decrease_of_joint_cost:
            break
    return best


def _simulate(
    simulator: Simulator, theta: Array, runs: Sequence[Run], columns: Sequence[int]
) -> tuple[list[Array], list[Array]]:
    """Return errors [rad] and their slopes of free simulations from the measured start, scored rows only."""
    errors, slopes = [], []
    for run in runs:
        made = simulator.simulate(theta, run, sensitivities=True)
        errors.append(np.asarray(run.y[run.scored, 0] - made.y[run.scored, 0]))
        assert made.dy_dtheta is not None
        slopes.append(np.asarray(made.dy_dtheta[run.scored, 0][:, columns]))
    return errors, slopes


def _move(found: Fit, theta: Array, columns: Sequence[int], step: Array) -> Array:
    """Return parameters moved by a step, inside their ranges, with stiction in its ratio to Coulomb friction."""
    rows, trial = found.equations.parameters, theta.copy()
    trial[columns] += step
    roles = law_named(found.equations.friction[0]).roles
    ids = [q.id for q in rows]
    coulomb, stiction = ids.index(roles.coulomb), ids.index(roles.stiction)
    if stiction != coulomb:
        trial[stiction] *= trial[coulomb] / theta[coulomb]
    parametrisation = Parametrisation.of(found.equations)
    for k, q in enumerate(rows):
        if q.id in parametrisation.ids:
            trial[k] = np.clip(trial[k], q.lower, q.upper)
    # Stiction may have ended at its bound; Coulomb friction is never above it.
    trial[coulomb] = min(trial[coulomb], trial[stiction])
    return trial
