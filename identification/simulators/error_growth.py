"""Growth of an error of the initial position in a free simulation: `Simulator` and `Run` in, growth factor out.

The factor decides whether a free simulation can be compared with a measurement.
"""

from __future__ import annotations

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run


def growth(simulator: Simulator, theta: Array, run: Run) -> float:
    """Compute the largest factor by which an error of the initial position grows during a run.

    Parameters
    ----------
    simulator
        Simulator with sensitivities.
    theta
        Parameters, shape (n_p,).
    run
        Run whose torques drive the simulation.

    Returns
    -------
    float
        max_t ‖∂y(t)/∂y(0)‖, the norm being the largest entry of the matrix (n_joints, n_joints). About 1 where springs,
        damping or friction hold the motion; hundreds and more where a pendulum comes near its upper rest. 0 where the
        growth is unknown: the simulation is not finite, or the simulator gives no sensitivities.
    """
    n = run.y.shape[1]
    made = simulator.simulate(theta, run, sensitivities=True)
    if made.dy_dx0 is None or not np.isfinite(grown := made.dy_dx0[:, :n, :n]).all():
        return 0.0
    return float(np.max(np.abs(grown)))
