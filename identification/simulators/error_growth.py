"""How fast a free simulation forgets or amplifies its start: whether it can be compared with a measurement at all."""

from __future__ import annotations

import numpy as np

from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run


def growth(simulator: Simulator, theta: Array, run: Run) -> float:
    """Return max_t ‖∂y(t)/∂y(0)‖, the largest factor by which an error of the first position grows during the run.

    The norm is the largest entry of the matrix (n_joints, n_joints). About 1 where springs, damping or friction hold
    the motion; hundreds and more where a pendulum comes near its upper rest. 0 where the simulation left the finite
    numbers or gives no sensitivities, because nothing is then known.
    """
    n = run.y.shape[1]
    made = simulator.simulate(theta, run, sensitivities=True)
    if made.dy_dx0 is None or not np.isfinite(made.dy_dx0).all():
        return 0.0
    return float(np.max(np.abs(made.dy_dx0[:, :n, :n])))
