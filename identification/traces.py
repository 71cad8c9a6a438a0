"""Measured and simulated signals of a fitted configuration, for figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from identification.fit import RunScore
from identification.simulator import Simulator
from identification.step import Step
from identification.torque import TorqueSimulator, torque_run
from measurement.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """One run: signals (n_t, n_joints) in ``unit``, the sensor's standard deviation, and that of the prediction.

    ``spread`` is what the parameters' covariance leaves open in the simulated signal.
    """

    score: RunScore
    joints: tuple[int, ...]
    t: Array
    measured: Array
    simulated: Array
    spread: Array
    sigma: Array
    unit: str
    scored_from: float


def traces_of(step: Step, simulator: Simulator) -> tuple[Trace, ...]:
    """Simulate every scored run of a step at the fitted parameters."""
    runs = {(run.file, run.use): run for run in step.configuration.runs}
    if step.torque_scored:
        runs = {key: torque_run(run) for key, run in runs.items()}
        simulator = TorqueSimulator.of(simulator.equations)
    free = [step.fit.index(id) for id in step.fit.free]
    made = []
    for score in step.fit.runs:
        run = runs[score.file, score.use]
        result = simulator.simulate(step.fit.theta, run, x0=score.x0, sensitivities=True)
        n = run.y.shape[1]
        assert result.dy_dtheta is not None  # noqa: S101 - asked for above
        J = result.dy_dtheta[:, :n, free]
        variance = np.einsum("tyi,ij,tyj->ty", J, step.fit.covariance, J)
        unit = ("N" if run.prismatic[0] else "N m") if step.torque_scored else ("m" if run.prismatic[0] else "rad")
        made.append(
            Trace(
                score=score,
                joints=run.free_joints,
                t=run.t,
                measured=run.y,
                simulated=result.y[:, :n],
                spread=np.sqrt(np.maximum(variance, 0.0)),
                sigma=run.sensor_std,
                unit=unit,
                scored_from=float(run.t[run.score_from]),
            )
        )
    return tuple(made)
