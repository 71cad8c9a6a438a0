"""Change of the readings with each cycle's torque: simulator and `Run` in, columns out.

One forward difference serves posterior and search. A kernel goes on from its state where a cycle begins and stops where
the joint has forgotten it; any other simulator simulates the whole run for each cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from haptid.identification.simulators.protocol import Resumable, Simulator
from haptid.measurement.signals.averaging import average_rows
from haptid.measurement.values.run import Array, Run
from haptid.noise.thresholds import THRESHOLDS


def torque_columns(
    simulator: Simulator, theta: Array, run: Run, x0: Array, index: NDArray[np.int64], *, column: int = 0
) -> Array:
    """Compute the change of the readings with each cycle's relative torque.

    Parameters
    ----------
    simulator
        Simulator of the model.
    theta
        Parameters, shape (n_p,).
    run
        Run of one or several joints.
    x0
        Initial state, shape (n_x,).
    index
        Number of the cycle of every row, ascending from 0, shape (n_t,).
    column
        Index in the run of the joint whose torque changes.

    Returns
    -------
    ndarray
        ∂y/∂ξ [rad] with the torque u·(1 + ξ) in a cycle, shape (n_t, n_joints, n_cycles).

    Notes
    -----
    Forward difference over ``THRESHOLDS.torque_change_of_scatter``. A torque that runs linearly between rows changes
    from the row before the cycle on.
    """
    change, count = THRESHOLDS.torque_change_of_scatter, int(index.max()) + 1
    M = np.zeros((*run.y.shape, count))

    def changed(c: int) -> Run:
        u = run.u.copy()
        u[index == c, column] *= 1.0 + change
        return run.but(u=u)

    if not isinstance(simulator, Resumable):
        y = _readings(simulator, theta, run, x0)
        for c in range(count):
            M[..., c] = (_readings(simulator, theta, changed(c), x0) - y) / change
        return M
    first = np.maximum(np.searchsorted(index, np.arange(count)) - 1, 0).tolist()
    y, states = _with_states(simulator, theta, run, x0, first)
    for c, (begin, end) in enumerate(pairwise((*first, run.t.size - 1))):
        M[..., c] = _change(simulator, theta, changed(c), states[c], y, begin, end) / change
    return M if run.averaged_rows <= 1 else average_rows(M, run.averaged_rows)


def _readings(simulator: Simulator, theta: Array, run: Run, x0: Array) -> Array:
    return simulator.simulate(theta, run, x0=x0).y[:, : run.y.shape[1]]


def _with_states(
    simulator: Resumable, theta: Array, run: Run, x0: Array, rows: Sequence[int]
) -> tuple[Array, list[Array]]:
    """Return the readings (n_t, n_joints) and the state at each of some ascending rows."""
    y: Array = np.empty(run.y.shape)
    x, states = x0, list[Array]()
    for row, until in pairwise((0, *rows, run.t.size - 1)):
        read, x = simulator.onward(theta, run, slice(row, until + 1), x)
        y[row : until + 1] = read[:, : y.shape[1]]
        states.append(x)
    return y, states[:-1]


def _change(simulator: Resumable, theta: Array, run: Run, x: Array, y: Array, begin: int, end: int) -> Array:
    """Return the change of the readings from ``y`` (n_t, n_joints), simulated from the state x at row ``begin``.

    The torque differs in the rows from ``begin`` to ``end``. The simulation stops where that difference is forgotten.
    """
    change, largest, last = np.zeros_like(y), 0.0, run.t.size - 1
    rows_of_part = max(end - begin, last // THRESHOLDS.most_parts_of_run, 1)
    for a, b in pairwise((begin, *range(end, last, rows_of_part), last)):
        rows = slice(a, b + 1)
        read, x = simulator.onward(theta, run, rows, x)
        change[rows] = read[:, : y.shape[1]] - y[rows]
        now = float(np.abs(change[rows]).max())
        if a != begin and now <= THRESHOLDS.forgotten_share_of_cycle_effect * largest:
            break
        largest = max(largest, now)
    return change
