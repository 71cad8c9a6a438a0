"""Friction states at the first row of a run that no fit saw: simulator, parameters and `Run` in, states out.

A run that begins in motion has deflected bristles. Fitted runs have their first states fitted; of another run its first
rows tell them, as they do in `identification.statistics.score`. Without them stiff bristles that begin at rest leave a
spike of σ1·v.
"""

from __future__ import annotations

from haptid.identification.simulators.inverse_dynamics import WIDTH
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.statistics.score import fit_initial_state, rows_of_start
from haptid.measurement.thresholds import THRESHOLDS as MEASUREMENT
from haptid.measurement.values.run import Array, Run


def first_states(simulator: Simulator, theta: Array, run: Run) -> Array:
    """Fit the states at the first row of a run to the torque of its first rows.

    Parameters
    ----------
    simulator
        Simulator from motion to torque.
    theta
        Parameters, shape (n_p,).
    run
        Run with the position as ``u`` and the torque as ``y``.

    Returns
    -------
    ndarray, shape (n_x,)
        States of friction law and effects.
    """
    rows = rows_of_start(run)
    # The filter of the torque reaches beyond the rows that count.
    beyond = int(2.0 * MEASUREMENT.filter_reach_in_widths * float(run.extra[WIDTH][0])) + 1
    kept = slice(0, rows + beyond)
    begun = run.but(
        t=run.t[kept], u=run.u[kept], y=run.y[kept], score_from=min(rows, run.t[kept].size - 1),
        extra={name: column[kept] for name, column in run.extra.items()},
    )  # fmt: skip
    return fit_initial_state(simulator, theta, begun)
