"""Initial states of a run as nuisance parameters: the position always, the velocity where the run starts in motion.

x₀ = m + w·δ with δ fitted per run. The position's m is the first sample and its w the sensor's deviation; the
first row of the residual is its prior. The velocity's m is the measured one, else 0; its w comes from the first
samples, and its prior is δ ~ N(0, 1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from haptid.identification.simulators.protocol import initial_state
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations

FIRST_ROWS = 9
MOVING = 6.0
"""Slope over its standard deviation from which a run counts as started in motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Where a run may start.

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
    """

    base: Array
    states: tuple[int, ...]
    unit: Array
    prior: Array

    def at(self, delta: Array) -> Array:
        """Return the initial state x₀, shape (n_x,)."""
        x0 = self.base.copy()
        x0[list(self.states)] += self.unit * delta
        return x0


def first_slopes(run: Run) -> tuple[Array, Array]:
    """Return initial velocities by a parabola through the first rows, and their standard deviations [rad/s]."""
    n = min(FIRST_ROWS, run.t.size)
    A = np.stack((np.ones(n), run.t[:n], run.t[:n] ** 2), axis=1)
    inverse = np.linalg.pinv(A)
    return (inverse @ run.y[:n])[1], run.sensor_std * float(np.linalg.norm(inverse[1]))


def start_of(equations: Equations, run: Run, *, free_velocity: bool = False) -> Start:
    """Return the nuisance parameters of ``run``: velocities join where asked for, measured, or seen at its start.

    Equations without joints are driven by the measured motion: their nuisances are all states, of their nominal size.
    """
    n = len(equations.joints)
    base = np.array(initial_state(equations, run))
    if not n:
        nominal = np.array([state.nominal for state in equations.states])
        return Start(base=base, states=tuple(range(base.size)), unit=nominal, prior=np.ones(base.size, dtype=bool))
    states, unit, prior = list(range(n)), list(run.sensor_std), [False] * n
    slope, std = first_slopes(run)
    moving = np.abs(slope) > MOVING * std
    if free_velocity or run.v is not None or bool(moving.any()):
        states += range(n, 2 * n)
        unit += list(np.maximum(3.0 * std, 0.3 * np.abs(base[n : 2 * n]) if run.v is not None else np.abs(slope)))
        prior += [True] * n
    return Start(base=base, states=tuple(states), unit=np.array(unit), prior=np.array(prior))
