"""The interface between models and fits: parameters and a `Run` in, `Trajectory` with sensitivities out.

Fits, samplers and the search for missing effects know a model as a `Simulator` only: an FMU, the compiled kernel, the
torque equation and the observer all satisfy it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np

from haptid.measurement.signals.averaging import average_rows
from haptid.measurement.values.run import Array, Run, freeze
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """Simulated outputs at a run's times.

    Parameters
    ----------
    t
        Time since the first row [s], shape (n_t,).
    y
        Outputs [rad], shape (n_t, n_y); NaN after a state is no longer a finite number.
    dy_dtheta
        Derivatives by the parameters, shape (n_t, n_y, n_p), or None without sensitivities.
    dy_dx0
        Derivatives by the initial states, shape (n_t, n_y, n_x), NaN by those that no fit moves; None without
        sensitivities.
    """

    t: Array
    y: Array
    dy_dtheta: Array | None = None
    dy_dx0: Array | None = None


class Simulator(Protocol):
    """Model that fits, samplers and the search for missing effects run."""

    @property
    def equations(self) -> Equations:
        """The equations without observer; theta is in the order of ``equations.parameters``."""

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """Simulate a run.

        Parameters
        ----------
        theta
            Parameters in the order of ``equations.parameters``, shape (n_p,).
        run
            Times, torques and, for the observer, measured positions.
        x0
            Initial state, shape (n_x,); `initial_state` where None.
        gain
            Observer gain L [1/s]; 0 simulates freely.
        sensitivities
            Whether the derivatives of the outputs are computed too.

        Returns
        -------
        Trajectory
        """


@runtime_checkable
class Stepped(Protocol):
    """Simulator whose inner step can be chosen."""

    def with_step(self, step: float) -> Simulator:
        """Return the same simulator with another inner step.

        Parameters
        ----------
        step
            Longest inner step [s].

        Returns
        -------
        Simulator
        """


@runtime_checkable
class Resumable(Protocol):
    """Simulator that can simulate some rows of a run from a state at the first of them."""

    def onward(self, theta: Array, run: Run, rows: slice, x: Array) -> tuple[Array, Array]:
        """Simulate some rows of a run, freely.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        run
            Run whose torques drive the simulation.
        rows
            Consecutive rows that are simulated.
        x
            State at the first of these rows, shape (n_x,).

        Returns
        -------
        y : ndarray, shape (n_rows, n_y)
            Outputs [rad] before any average over rows, bit by bit those of a simulation of the whole run.
        last : ndarray, shape (n_x,)
            State at the last row.
        """


def at_step(simulator: Simulator, step: float) -> Simulator:
    """Set the inner step of a simulator that has one.

    Parameters
    ----------
    simulator
        Any simulator.
    step
        Longest inner step of the integration [s].

    Returns
    -------
    Simulator
        A simulator with that step, or ``simulator`` itself where its inner step cannot be chosen.
    """
    return simulator.with_step(step) if isinstance(simulator, Stepped) else simulator


def initial_state(equations: Equations, run: Run) -> Array:
    """Return the initial state that a run's first row gives.

    Parameters
    ----------
    equations
        Equations whose first states are the positions, then the velocities of the joints.
    run
        Run with positions y and perhaps measured velocities v.

    Returns
    -------
    ndarray, shape (n_x,)
        First position [rad], measured velocity or 0 [rad/s], other states at their start values; read-only.
    """
    x0 = np.array([s.start for s in equations.states])
    n = len(equations.joints)
    x0[:n] = run.y[0, :n]  # without joints the outputs are no positions
    if run.v is not None:
        x0[n : 2 * n] = run.v[0]
    return freeze(x0)


def as_recorded(run: Run, made: Trajectory) -> Trajectory:
    """Average a simulation over rows as the recorder of a run averaged its positions.

    Parameters
    ----------
    run
        Run with its ``averaged_rows``.
    made
        Simulated outputs and sensitivities.

    Returns
    -------
    Trajectory
        The averages; ``made`` itself where the recorder did not average.
    """
    if run.averaged_rows <= 1:
        return made
    slopes = (made.dy_dtheta, made.dy_dx0)
    by_theta, by_x0 = (None if slope is None else average_rows(slope, run.averaged_rows) for slope in slopes)
    return replace(made, y=average_rows(made.y, run.averaged_rows), dy_dtheta=by_theta, dy_dx0=by_x0)


def observer_inputs(run: Run, gain: float, rows: slice = slice(None)) -> Array:
    """Arrange the inputs of equations with observer.

    Parameters
    ----------
    run
        Run with torques u and positions y, shape (n_t, n_joints) each.
    gain
        Observer gain L [1/s].
    rows
        Rows that are wanted.

    Returns
    -------
    ndarray, shape (n_rows, n_inputs + n_joints + 1)
        Torques [N m] or inputs of the drive, measured positions [rad], gain [1/s].
    """
    return np.column_stack((run.inputs[rows], run.y[rows], np.full(run.t[rows].size, gain)))


def observer_hold(run: Run) -> tuple[bool, ...]:
    """Say which columns of `observer_inputs` are linear between rows; the others hold their value until the next row.

    Parameters
    ----------
    run
        Run whose ``hold`` applies to the torques.

    Returns
    -------
    tuple of bool, length n_inputs + n_joints + 1
        Torques, or the first input of a drive, as ``run.hold`` says, measured positions linear, gain held.
    """
    n = len(run.free_joints)
    driven = run.inputs.shape[1] - n
    # Behind the command of a drive come supply, switch and gain, which hold their values.
    return (run.hold == "linear",) * n + (False,) * driven + (True,) * n + (False,)
