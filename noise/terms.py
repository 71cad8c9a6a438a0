"""Runs made ready for their likelihood: `Run` in, `Terms` with cycles, start and linearised random columns out.

The columns ∂y/∂x₀ and ∂y/∂ξ are taken once at the mode and kept fixed for all parameter sets, so that a likelihood
needs one simulation per parameter set.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from haptid.identification.problem.initial_states import start_of
from haptid.identification.simulators.protocol import Simulator, Trajectory
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.noise.cycle_torque import torque_columns
from haptid.noise.noise_model import NoiseModel
from haptid.noise.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """A run made ready for its likelihood.

    Parameters
    ----------
    run
        The run of one free joint.
    cycle
        Number of the cycle of every row, shape (n_t,).
    x0
        Initial state around which the model is linear in the initial position, shape (n_x,).
    fixed
        Random columns that are taken once, at the mode: ∂y/∂x₀, and with scatter on the torque ∂y/∂ξ of every cycle,
        and the sum of these where runs scatter too; shape (n_fixed, n_t).
    states
        The initial states that are random: the position, and the velocity where the run starts in motion.
    start_std
        Prior standard deviation of each of them [rad], [rad/s].
    start_shift
        Centre of their prior minus ``x0``: the prior mean of the column's coefficient.
    correction
        What a fine inner step adds to the simulated positions at the mode [rad], shape (n_t,).
    """

    run: Run
    cycle: NDArray[np.int64]
    x0: Array
    fixed: Array
    states: tuple[int, ...]
    start_std: Array
    start_shift: Array
    correction: Array

    @property
    def cycles(self) -> int:
        """Number of cycles."""
        return int(self.cycle[-1]) + 1

    @property
    def slices(self) -> list[slice]:
        """Rows of each cycle."""
        edges = [0, *(np.flatnonzero(np.diff(self.cycle)) + 1).tolist(), self.cycle.size]
        return [slice(a, b) for a, b in pairwise(edges)]

    @property
    def sensor_std(self) -> float:
        """Standard deviation of the white noise [rad]."""
        return float(self.run.sensor_std[0])

    @property
    def data(self) -> Array:
        """Measured positions less ``correction`` [rad], shape (n_t,): what the simulation in use should give."""
        return np.asarray(self.run.y[:, 0] - self.correction)

    def but(self, **changes: Any) -> Terms:
        """Return a copy with changed fields.

        Parameters
        ----------
        **changes
            New values by field name.

        Returns
        -------
        Terms
            The copy.
        """
        return replace(self, **changes)


def prepare(equations: Equations, run: Run, x0: Array | None = None) -> Terms:
    """Make a run ready for its likelihood; its random columns are not taken yet.

    Parameters
    ----------
    equations
        Equations of the free joint.
    run
        The run.
    x0
        Initial state around which the start is linearised, shape (n_x,); that of the first sample where None.

    Returns
    -------
    Terms
        The run with cycles and prior of its initial states; ``fixed`` has no column yet and ``correction`` is 0.
    """
    start = start_of(equations, run)
    travel = float(np.ptp(run.y[:, 0]))
    std = start.unit.copy()
    if equations.joints:
        # A run that hardly moves has a travel of the size of its noise: the second keeps its prior wide against that.
        std[0] = max(THRESHOLDS.initial_position_std_over_travel * travel, 10 * float(run.sensor_std[0]))
    at = start.base.copy() if x0 is None else np.array(x0)
    return Terms(
        run=run,
        cycle=whole_cycles(run).index,
        x0=at,
        fixed=np.empty((0, run.t.size)),
        states=start.states,
        start_std=std,
        start_shift=(start.base - at)[list(start.states)],
        correction=np.zeros(run.t.size),
    )


def linearise(terms: Terms, trajectory: Trajectory) -> Terms:
    """Take the columns ∂y/∂x₀ of the initial states from a trajectory; the other fixed columns stay.

    Parameters
    ----------
    terms
        The run.
    trajectory
        Simulation of the run with sensitivities, from the initial state ``terms.x0``.

    Returns
    -------
    Terms
        Copy whose first columns in ``fixed`` are those of ``states``.

    Raises
    ------
    ValueError
        Where the trajectory has no sensitivities.
    """
    if trajectory.dy_dx0 is None:
        msg = "a trajectory with sensitivities is needed"
        raise ValueError(msg)
    start = [trajectory.dy_dx0[:, 0, i] for i in terms.states]
    return terms.but(fixed=np.array([*start, *terms.fixed[len(start) :]]))


def scatter_columns(terms: Terms, simulator: Simulator, theta: Array, model: NoiseModel) -> Terms:
    """Take the columns ∂y/∂ξ of a scatter on the torque, and their sum where runs scatter too.

    Parameters
    ----------
    terms
        The run.
    simulator
        Simulates the run once, and once more for every cycle.
    theta
        Parameters at which the columns are taken, shape (n_p,).
    model
        Random parts of the data; without scatter on the torque ``terms`` is returned as it is.

    Returns
    -------
    Terms
        Copy with the columns of all cycles in ``fixed``, after those of the initial states.
    """
    if model.scatter != "torque":
        return terms
    cycles = list(torque_columns(simulator, theta, terms.run, terms.x0, terms.cycle)[:, 0].T)
    n = len(terms.states)
    # The columns of the start come first; zeros hold their place until `linearise` takes them.
    start = terms.fixed[:n] if len(terms.fixed) >= n else np.zeros((n, terms.run.t.size))
    return terms.but(fixed=np.array([*start, *cycles, *([np.sum(cycles, axis=0)] if model.runs else [])]))


def column_scales(terms: Terms, model: NoiseModel, hyper: dict[str, Array]) -> Array:
    """Return the standard deviations λ of the random columns' coefficients.

    Parameters
    ----------
    terms
        The run.
    model
        Random parts of the data.
    hyper
        Values of the noise model's parameters by id, shape (n_sets,) each.

    Returns
    -------
    ndarray, shape (n_sets, k)
        In order: initial states [rad], [rad/s], every cycle [1], run [1].
    """
    sets = hyper["noise_factor"].shape[0]
    parts = [np.broadcast_to(terms.start_std, (sets, terms.start_std.size))]
    if model.scatter != "none":
        parts.append(np.repeat(hyper["cycle_scatter"][:, None], terms.cycles, axis=1))
    if model.runs:
        parts.append(hyper["run_scatter"][:, None])
    return np.concatenate(parts, axis=1)
