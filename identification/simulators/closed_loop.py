"""Simulation in closed loop: compiled model, `Run`, `Controller` and reference in, positions and torques out.

The controller that moved the machine closes the loop around the model:
τ_k = Kp·(r_k − y_k) − Kd·v̂_k, v̂ the differenced positions behind a first-order low-pass,
v̂_k = v̂_{k−1} + h/(h + T)·((y_k − y_{k−1})/h − v̂_{k−1}), v̂_0 = 0; τ_k holds until the next row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from haptid.measurement.signals.averaging import average_rows
from haptid.measurement.values.run import Array, Run, freeze
from haptid.model.kernel.compiled import CompiledKernel
from haptid.support.errors import InputError

TABLE = "campaign.toml, [controller]"
PROPORTIONAL, DERIVATIVE, FILTER = "Kp_Nm_per_rad", "Kd_Nms_per_rad", "filter_time_constant_s"


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """Proportional-derivative controller of all joints, sampled at the rows of a run.

    Parameters
    ----------
    proportional
        Kp [N m/rad], shape (n_q,).
    derivative
        Kd [N m s/rad], shape (n_q,).
    filter_s
        Time constant T of the low-pass on the differenced positions [s].
    law
        Description of the controller in the campaign.
    """

    proportional: Array
    derivative: Array
    filter_s: float = 0.0
    law: str = ""

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        object.__setattr__(self, "proportional", freeze(self.proportional))
        object.__setattr__(self, "derivative", freeze(self.derivative))

    @classmethod
    def from_table(cls, table: Mapping[str, Any], joints: int) -> Controller:
        """Read the ``[controller]`` table of a campaign.

        Parameters
        ----------
        table
            The table, with one proportional and one derivative gain per joint.
        joints
            Number of joints.

        Returns
        -------
        Controller

        Raises
        ------
        InputError
            Where a key is missing, has another number of gains, or is no finite number; the message names the key.
        """
        return cls(
            proportional=_gains(table, PROPORTIONAL, joints),
            derivative=_gains(table, DERIVATIVE, joints),
            filter_s=_filter(table),
            law=str(table.get("law", "")),
        )

    def velocity(self, last: Array, change: Array, step: float) -> Array:
        """Update the filtered velocity.

        Parameters
        ----------
        last
            v̂ at the row before [rad/s], shape (n_q,).
        change
            Change of the reading since that row [rad], shape (n_q,).
        step
            Time h between the rows [s].

        Returns
        -------
        ndarray, shape (n_q,)
            v̂ + h/(h + T)·(change/h − v̂) [rad/s].
        """
        return last + step / (step + self.filter_s) * (change / step - last)

    def torque(self, reference: Array, reading: Array, velocity: Array) -> Array:
        """Compute the torque Kp·(r − y) − Kd·v̂.

        Parameters
        ----------
        reference, reading
            Reference position r and position reading y [rad], shape (n_q,).
        velocity
            Filtered velocity v̂ [rad/s], shape (n_q,).

        Returns
        -------
        ndarray, shape (n_q,)
            τ [N m].
        """
        return self.proportional * (reference - reading) - self.derivative * velocity


def _gains(table: Mapping[str, Any], key: str, joints: int) -> Array:
    values = table.get(key)
    right = isinstance(values, Sequence) and not isinstance(values, str) and len(values) == joints
    if not right or not all(isinstance(v, int | float) and np.isfinite(v) for v in values or ()):
        where = f"{TABLE}.{key}"
        raise InputError(where, expected=f"{joints} numbers, one per joint", got=repr(values))
    return freeze(values or ())


def _filter(table: Mapping[str, Any]) -> float:
    value = table.get(FILTER, 0.0)
    if not isinstance(value, int | float) or not 0.0 <= value < np.inf:
        where = f"{TABLE}.{FILTER}"
        raise InputError(where, expected="a time constant of at least 0 s", got=repr(value))
    return float(value)


def reference_of(run: Run) -> Array | None:
    """Collect the recorded reference positions of all free joints.

    Parameters
    ----------
    run
        Run whose further columns may hold ``reference_<joint>_rad`` or ``reference_<joint>_m``.

    Returns
    -------
    ndarray, shape (n_t, n_q), or None
        References [rad]; None where a joint has no reference or a reference is not finite.
    """
    columns = []
    for joint in run.free_joints:
        names = [name for name in (f"reference_{joint}_rad", f"reference_{joint}_m") if name in run.extra]
        if not names or not bool(np.isfinite(run.extra[names[0]]).all()):
            return None
        columns.append(run.extra[names[0]])
    return np.column_stack(columns)


def start_at_rest(kernel: CompiledKernel, run: Run) -> Array:
    """Return the initial state: first positions, measured velocities or 0, other states at their start values.

    Parameters
    ----------
    kernel
        Compiled model with the positions, then the velocities, as its first states.
    run
        Run whose first row gives positions and velocities.

    Returns
    -------
    ndarray, shape (n_x,)
        Positions [rad], velocities [rad/s], then the other states in their units.
    """
    n = len(run.free_joints)
    x = np.array([state.start for state in kernel.equations.states])
    x[:n] = run.y[0]
    if run.v is not None:
        x[n : 2 * n] = run.v[0]
    return x


def simulate_closed_loop(
    kernel: CompiledKernel,
    theta: Array,
    run: Run,
    controller: Controller,
    reference: Array,
    *,
    reading_noise: Array | None = None,
) -> tuple[Array, Array]:
    """Simulate the model under the controller.

    Parameters
    ----------
    kernel
        Compiled model.
    theta
        Parameters of the kernel, shape (n_p,).
    run
        Run that gives times and initial state.
    controller
        Controller that closes the loop.
    reference
        Reference positions [rad], shape (n_t, n_q).
    reading_noise
        Noise added to the positions that the controller reads [rad], shape (n_t, n_q); no noise where None.

    Returns
    -------
    y : ndarray, shape (n_t, n_q)
        Positions [rad] without the reading noise.
    torque : ndarray, shape (n_t, n_q)
        Torques of the controller [N m]. Both are NaN in the rows after a state is no longer a finite number.
    """
    n, rows = len(run.free_joints), run.t.size
    noise = np.zeros((rows, n)) if reading_noise is None else reading_noise
    y, torque = np.full((rows, n), np.nan), np.full((rows, n), np.nan)
    x, velocity, last = start_at_rest(kernel, run), np.zeros(n), run.y[0]
    u = np.zeros(len(kernel.equations.inputs))
    for k in range(rows):
        y[k] = x[:n]
        reading = y[k] + noise[k]
        if k:
            velocity = controller.velocity(velocity, reading - last, float(run.t[k] - run.t[k - 1]))
        torque[k] = u[:n] = controller.torque(reference[k], reading, velocity)
        last = reading
        if k + 1 < rows:
            x = kernel.advance(x, float(run.t[k]), float(run.t[k + 1] - run.t[k]), u, theta)
            if not np.isfinite(x[0]):
                break
    return y, torque


def simulate_recorded(kernel: CompiledKernel, theta: Array, run: Run) -> Array:
    """Simulate the model under the recorded torques, in open loop.

    Parameters
    ----------
    kernel
        Compiled model; its inputs beyond the torques are 0.
    theta
        Parameters of the kernel, shape (n_p,).
    run
        Run that gives times, torques and initial state.

    Returns
    -------
    ndarray, shape (n_t, n_q)
        Positions [rad].
    """
    n = len(run.free_joints)
    inputs = np.zeros((run.t.size, len(kernel.equations.inputs)))
    inputs[:, :n] = run.u
    y = kernel.simulate(run.t, inputs, theta, start_at_rest(kernel, run), linear=run.hold == "linear")
    return average_rows(y[:, :n], run.averaged_rows)
