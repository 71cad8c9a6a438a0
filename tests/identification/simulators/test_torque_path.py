"""Effects on the path of the torque, read from motion to torque: followed forward from the recorded torque."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_equations, torque_run, torque_runs
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.joint.locked_joint import joint_equations

TRUTH = {
    "inertia": 0.17, "gravity_cos": 0.0, "gravity_sin": 3.3, "Kp": 1.0, "Ks": 0.0, "epos": 0.0, "sigma0": 300.0,
    "sigma1": 1.0, "sigma2": 0.02, "vs": 0.05, "Fs": 0.17, "Fc": 0.16,
}  # fmt: skip
UNIT = Scales()
T = np.arange(0.0, 8.0, 0.002)


@pytest.mark.parametrize(
    ("key", "id", "value"), [("time_delay", "delay_time", 0.03), ("amplifier_lag:rest", "lag_time", 0.02)]
)
def test_late_torque_is_read_where_it_arrives(key: str, id: str, value: float):
    effect = catalogue()[key].at(UNIT)
    late, prompt = joint_equations(0, effects=[effect]), joint_equations(0)
    torque = 3.0 * np.sin(5.0 * T) + 2.0 * np.sin(8.3 * T)
    made = Run(
        file="a", free_joints=(0,), t=T, u=torque[:, None], y=np.zeros((T.size, 1)),
        noise=np.array([1e-5]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip
    truth = TRUTH | {x.id: x.initial for x in effect.parameters} | {id: value}
    theta = np.array([truth[q.id] for q in late.parameters])
    recorded = torque_run(made.but(y=KernelSimulator.of(late).simulate(theta, made).y[:, :1]))
    simulator = TorqueSimulator.of_torque(torque_equations(late, prompt))
    without = TorqueSimulator.of(prompt)

    def missed(by: TorqueSimulator, values: dict[str, float]) -> float:
        at = np.array([values[q.id] for q in by.equations.parameters])
        error = (by.simulate(at, recorded).y - recorded.y)[300:-300]
        return float(np.sqrt(np.mean(error**2)))

    left = missed(simulator, truth)
    # Without the effect the same equation is that of the nominal model.
    assert missed(simulator, truth | effect.neutral) == pytest.approx(missed(without, truth), rel=1e-3)
    assert left < 0.15 * missed(without, truth)
    assert left < missed(simulator, truth | {id: 0.7 * value})
    assert left < missed(simulator, truth | {id: 1.3 * value})


def commanded(file: str, torque: np.ndarray, seed: int) -> Run:
    """Return a run whose torque was recorded with that noise, along a motion of no matter."""
    rng = np.random.default_rng(seed)
    position = 0.4 * np.sin(3.0 * T) + 1e-5 * rng.standard_normal(T.size)
    return Run(
        file=file, free_joints=(0,), t=T, u=torque[:, None], y=position[:, None],
        noise=np.array([1e-5]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip


def test_a_torque_that_rests_for_most_of_its_time_has_the_noise_of_the_other_runs():
    noise, rng = 0.05, np.random.default_rng(3)
    # Steps of a position controller: no command at rest, a short push at each step.
    pushes = np.where(np.mod(T, 2.0) < 0.2, 2.0 * np.cos(8.0 * T), 0.0)
    runs = [commanded("steps", pushes, 1)] + [
        commanded(f"sweep_{k}", 2.0 * np.sin((4.0 + k) * T) + noise * rng.standard_normal(T.size), k) for k in (2, 3)
    ]
    alone = [float(torque_run(run).noise[0]) for run in runs]
    assert alone[0] < 1e-4 * alone[1]
    steps, *sweeps = (float(run.noise[0]) for run in torque_runs(runs))
    assert steps == pytest.approx(min(sweeps), rel=0.05)


def test_a_torque_in_coarse_steps_has_at_least_the_error_of_its_step():
    step = 0.3
    torque = step * np.round(30.0 * np.where(np.mod(T, 2.0) < 0.4, np.cos(8.0 * T), 0.0) / step)
    turned = torque_run(commanded("rated", torque, 1))
    gain = float(torque_run(commanded("unit", np.random.default_rng(2).standard_normal(T.size), 1)).noise[0])
    assert float(turned.noise[0]) == pytest.approx(gain * step / np.sqrt(12.0), rel=0.1)
