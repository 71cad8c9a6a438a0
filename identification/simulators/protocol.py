"""The seam between models and fits: a simulator turns parameters and a run into a trajectory, with sensitivities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from haptid.measurement.values.run import Array, Run, frozen
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """Simulated outputs at a run's times.

    Parameters
    ----------
    t
        Time since the first row [s], shape (n_t,).
    y
        Outputs [rad], shape (n_t, n_y); NaN after the state has left the finite numbers.
    dy_dtheta
        Derivatives with respect to the parameters, shape (n_t, n_y, n_p), or None.
    dy_dx0
        Derivatives with respect to the initial states, shape (n_t, n_y, n_x), or None.
    """

    t: Array
    y: Array
    dy_dtheta: Array | None = None
    dy_dx0: Array | None = None


class Simulator(Protocol):
    """What fits, samplers and the search for missing effects see of a model."""

    @property
    def equations(self) -> Equations:
        """The equations without observer; theta is in the order of ``equations.parameters``."""

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """Simulate ``run`` from the state ``x0`` (`initial_state` where None) with observer gain ``gain`` [1/s]."""


@runtime_checkable
class Stepped(Protocol):
    """A simulator whose inner step can be chosen."""

    def with_step(self, step: float) -> Simulator:
        """Return the same with inner steps of at most ``step`` [s]."""


def at_step(simulator: Simulator, step: float) -> Simulator:
    """Return the simulator with inner steps of at most ``step`` [s]; as it is where it has no such choice."""
    return simulator.with_step(step) if isinstance(simulator, Stepped) else simulator


def initial_state(equations: Equations, run: Run) -> Array:
    """Return the first sample as position, measured speed (else rest), other states at their start, shape (n_x,)."""
    x0 = np.array([s.start for s in equations.states])
    n = len(equations.joints)
    x0[:n] = run.y[0]
    if run.v is not None:
        x0[n : 2 * n] = run.v[0]
    return frozen(x0)


def observer_inputs(run: Run, gain: float) -> Array:
    """Return torques, measured positions and observer gain, shape (n_t, 2·n_joints + 1)."""
    return np.column_stack((run.u, run.y, np.full(run.t.size, gain)))


def observer_hold(run: Run) -> tuple[bool, ...]:
    """Return which of `observer_inputs` run linearly: torque as the run says, measured position always, gain never."""
    n = len(run.free_joints)
    return (run.hold == "linear",) * n + (True,) * n + (False,)
