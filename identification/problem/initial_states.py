"""Initial states of a run as nuisance parameters: `Equations` and `Run` in, `Start` out.

The initial position is always fitted, the initial velocity where the run starts in motion: x₀ = m + w·δ with δ fitted
per run.

- Position: m is the first sample, w the sensor's standard deviation; the first row of the residual is its prior.
- Velocity: m is the measured velocity, else 0; w comes from the first samples; the prior is δ ~ N(0, 1).
- A state whose start value differs from run to run (`State.start_std`): m is its start, w that standard deviation, the
  prior δ ~ N(0, 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.simulators.protocol import initial_state
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Initial state of one run as a linear function x₀ = base + w·δ of its nuisance parameters δ.

    Parameters
    ----------
    base
        Initial state at δ = 0, shape (n_x,).
    states
        Indices of the states that are fitted, shape (n_δ,).
    unit
        w, shape (n_δ,).
    prior
        Which δ have the prior N(0, 1), shape (n_δ,).
    guess
        δ of a run that is clearly in motion, shape (n_δ,): the slope of its first rows, else 0. A fit has the help of
        the observer on the way from rest; without it, a descent ends where a joint that coasts sticks to its friction.
    """

    base: Array
    states: tuple[int, ...]
    unit: Array
    prior: Array
    guess: Array

    def at(self, delta: Array) -> Array:
        """Evaluate the initial state x₀ = base + w·δ.

        Parameters
        ----------
        delta
            δ, shape (n_δ,).

        Returns
        -------
        ndarray, shape (n_x,)
            Positions [rad], velocities [rad/s], then the other states in their units.
        """
        x0 = self.base.copy()
        x0[list(self.states)] += self.unit * delta
        return x0

    def delta_of(self, x0: Array) -> Array:
        """Return the nuisance parameters δ of an initial state, the inverse of `at`.

        Parameters
        ----------
        x0
            Initial state, shape (n_x,).

        Returns
        -------
        ndarray, shape (n_δ,)
        """
        index = list(self.states)
        return np.asarray((x0[index] - self.base[index]) / self.unit)


def first_slopes(run: Run, rows: int = THRESHOLDS.rows_of_initial_velocity) -> tuple[Array, Array]:
    """Estimate the initial velocities by a parabola through the first rows.

    Parameters
    ----------
    run
        Run with positions y [rad], shape (n_t, n_joints).
    rows
        Number of rows that the parabola is fitted to.

    Returns
    -------
    velocity : ndarray, shape (n_joints,)
        Derivative of the parabola at t = 0 [rad/s].
    std : ndarray, shape (n_joints,)
        Standard deviation of the velocity that the sensor's noise causes [rad/s].
    """
    n = min(rows, run.t.size)
    A = np.stack((np.ones(n), run.t[:n], run.t[:n] ** 2), axis=1)
    inverse = np.linalg.pinv(A)
    return (inverse @ run.y[:n])[1], run.sensor_std * float(np.linalg.norm(inverse[1]))


def _velocity_guess(run: Run) -> Array:
    """Guess the initial velocities of joints that are clearly in motion [rad/s]; those of others are 0.

    So are all where velocities are measured, which the base has. Few rows count: the jerk of a joint that breaks loose
    from rest looks like a velocity in many.
    """
    slope, std = first_slopes(run, THRESHOLDS.rows_of_velocity_guess)
    clear = np.abs(slope) > THRESHOLDS.least_initial_velocity_in_std * std
    return np.where(clear & (run.v is None), slope, 0.0)


def start_of(equations: Equations, run: Run, *, free_velocity: bool = False) -> Start:
    """Choose the nuisance parameters of a run's initial state, their units and their priors.

    Parameters
    ----------
    equations
        Equations that are simulated.
    run
        Run whose first rows give positions and velocities.
    free_velocity
        Whether the initial velocities are fitted in any case; otherwise they are fitted where the run has measured
        velocities, or where the slope of a joint's first rows exceeds `THRESHOLDS.least_initial_velocity_in_std`
        standard deviations.

    Returns
    -------
    Start

    Notes
    -----
    Equations without joints are driven by the measured motion: all their states are fitted, in units of their nominal
    size and with the prior δ ~ N(0, 1).
    """
    n = len(equations.joints)
    base = np.array(initial_state(equations, run))
    if not n:
        nominal = np.array([state.nominal for state in equations.states])
        return Start(
            base=base,
            states=equations.starts,
            unit=nominal,
            prior=np.ones(base.size, dtype=bool),
            guess=np.zeros(base.size),
        )
    states, unit, prior, guess = list(range(n)), list(run.sensor_std), [False] * n, [0.0] * n
    slope, std = first_slopes(run)
    moving = np.abs(slope) > THRESHOLDS.least_initial_velocity_in_std * std
    if free_velocity or run.v is not None or bool(moving.any()):
        states += range(n, 2 * n)
        # The prior N(0, w²) is centred at rest without measured velocities: w must then cover the slope itself.
        width = np.maximum(3.0 * std, 0.3 * np.abs(base[n : 2 * n]) if run.v is not None else np.abs(slope))
        unit += list(width)
        prior += [True] * n
        guess += list(_velocity_guess(run) / width)
    differing = equations.starts[2 * n :]
    states += differing
    unit += [equations.states[k].start_std for k in differing]
    prior += [True] * len(differing)
    guess += [0.0] * len(differing)
    return Start(base=base, states=tuple(states), unit=np.array(unit), prior=np.array(prior), guess=np.array(guess))
