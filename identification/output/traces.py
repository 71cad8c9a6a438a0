"""Measured and simulated signals of a fitted configuration, for figures: `Step` and simulator in, `Trace`s out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from haptid.identification.result.fit import RunScore
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_runs
from haptid.identification.simulators.observer import Observed
from haptid.identification.simulators.protocol import Simulator, at_step
from haptid.measurement.values.run import Array, Run
from haptid.measurement.values.units import unit_for
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """Signals of one run.

    Parameters
    ----------
    score
        Score of the run.
    joints
        Numbers of the free joints.
    t
        Times [s], shape (n_t,).
    measured, simulated
        Signals in ``unit``, shape (n_t, n_joints).
    spread
        Standard deviation of the simulated signal by the parameters' covariance, in ``unit``, shape (n_t, n_joints).
    sigma
        Sensor standard deviation in ``unit``, shape (n_joints,).
    unit
        Unit of the signals: of position, or of torque where the torque was fitted.
    scored_from
        Time of the first scored row [s].
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
    """Simulate every scored run of a step at the estimates.

    Parameters
    ----------
    step
        Configuration with its fit.
    simulator_of
        Function from equations to a simulator.

    Returns
    -------
    tuple of Trace
        Signals with spread √diag(J·C·Jᵀ), J the sensitivities and C the covariance of the fitted parameters.
    """
    runs: dict[tuple[str, str], Run] = {(run.file, run.use): run for run in step.configuration.runs}
    if step.torque_scored:
        runs = dict(zip(runs, torque_runs([*runs.values()], _delay_of(step), step.fit.values["inertia"]), strict=True))
    simulator = _simulator(step, simulator_of)
    free = [step.fit.index(id) for id in step.fit.free]
    made = []
    for score in step.fit.runs:
        run = runs[score.file, score.use]
        result = simulator.simulate(step.fit.theta, run, x0=score.x0, sensitivities=True)
        n = run.y.shape[1]
        J = _require_sensitivities(result.dy_dtheta)[:, :n, free]
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


def _delay_of(step: Step) -> float:
    return 0.0 if step.compared is None else step.compared.delay_s


def _simulator(step: Step, simulator_of: Callable[[Equations], Simulator]) -> Simulator:
    """Return the simulator of the fit at its inner step: torque equation, observer, or free simulation."""
    if step.torque_scored:
        return TorqueSimulator.of_torque(step.fit.equations)
    base = at_step(simulator_of(step.fit.equations), step.fit.inner_step)
    return Observed(base, step.fit.observer_gain) if step.fit.observer_gain > 0 else base


def _require_sensitivities(values: Array | None) -> Array:
    """Return the sensitivities; raise ValueError where the simulator gave none."""
    if values is None:
        msg = "the simulator returned no sensitivities"
        raise ValueError(msg)
    return values
