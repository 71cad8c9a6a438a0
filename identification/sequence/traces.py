"""Measured and simulated signals of a fitted configuration, for figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from haptid.identification.result.fit import RunScore
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_run
from haptid.identification.simulators.observer import Observed
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.model.equations.equations import Equations


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


def traces_of(step: Step, simulator_of: Callable[[Equations], Simulator]) -> tuple[Trace, ...]:
    """Simulate every scored run of a step at the fitted parameters."""
    runs: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in step.configuration.runs}
    if step.torque_scored:
        runs = {key: torque_run(run) for key, run in runs.items()}
    simulator = _simulator(step, simulator_of)
    free = [step.fit.index(id) for id in step.fit.free]
    made = []
    for score in step.fit.runs:
        run = runs[score.file, score.use]
        result = simulator.simulate(step.fit.theta, run, x0=score.x0, sensitivities=True)
        n = run.y.shape[1]
        J = _asked(result.dy_dtheta)[:, :n, free]
        variance = np.einsum("tyi,ij,tyj->ty", J, step.fit.covariance, J)
        unit = unit_for("N m" if step.torque_scored else "rad", run.prismatic)
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


def _simulator(step: Step, simulator_of: Callable[[Equations], Simulator]) -> Simulator:
    """Return what simulates as the fit did."""
    if step.torque_scored:
        return TorqueSimulator.of_torque(step.fit.equations)
    base = simulator_of(step.fit.equations)
    return Observed(base, step.fit.observer_gain) if step.fit.observer_gain > 0 else base


def _asked(values: Array | None) -> Array:
    """Return sensitivities that were asked for."""
    if values is None:
        msg = "the simulator returned no sensitivities"
        raise ValueError(msg)
    return values
