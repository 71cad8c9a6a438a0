"""Free simulation of the unseen runs of a joint: `TorqueFit` in, RMS error of the position out.

A torque along the measured motion does not ask where the model would go by itself, which is what an FMU is used for.
"""

from __future__ import annotations

import numpy as np

from haptid.discrepancy.torque.fit import TorqueFit
from haptid.identification.baseline.delay import with_delayed_torque
from haptid.identification.problem.initial_states import first_slopes
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import initial_state
from haptid.support.linear_algebra import rms


def free_rms(model: TorqueFit) -> float | None:
    """Simulate the unseen runs from their measured starts, driven by the recorded torque.

    Parameters
    ----------
    model
        Fit to the torque.

    Returns
    -------
    float or None
        RMS error of the position over all scored rows [rad], or [m] of a prismatic joint; infinite where a simulation
        does not stay finite. None without unseen runs, and for a joint with a drive, whose torque follows the motion.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    study = model.study
    unseen = [run for run in (*study.recorded, *study.recorded_sealed) if run.use != "fit"]
    if study.drive is not None or not unseen:
        return None
    simulator = KernelSimulator.of(study.equations(model.effects))
    theta = np.array([model.values[q.id] for q in simulator.equations.parameters])
    errors = []
    for run in unseen:
        driven = with_delayed_torque(run, study.delay)
        start = np.array(initial_state(simulator.equations, run))
        if run.v is None:
            # From rest, a run that begins in motion would be off by its speed times the joint's time constant. No
            # descent mends the slope, as it does `Start.guess`, whose fewer rows have twice the error and miss a speed
            # within the noise.
            start[1] = first_slopes(run)[0][0]
        errors.append((run.y - simulator.simulate(theta, driven, x0=start).y)[run.scored, 0])
    left = rms(np.concatenate(errors))
    return left if np.isfinite(left) else float("inf")
