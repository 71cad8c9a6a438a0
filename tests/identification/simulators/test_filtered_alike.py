"""What is not linear in the motion passes the filter as often as the measured torque: waves and dry friction."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.baseline.regressor import Regressor
from haptid.identification.baseline.torque_along import TorqueAlong
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_equations, torque_run
from haptid.measurement.signals.filtered_motion import filter_run
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.registry import catalogue
from haptid.model.effects.scales import Scales
from haptid.model.joint.locked_joint import joint_equations

TRUTH = {
    "inertia": 0.02, "gravity_cos": 0.0, "gravity_sin": 0.3, "Kp": 1.0, "Ks": 0.1, "epos": 0.0, "sigma0": 1e6,
    "sigma1": 0.0, "sigma2": 0.05, "vs": 0.5, "Fs": 0.08, "Fc": 0.08,
}  # fmt: skip
WAVE = {"cogging_sin": 0.05, "cogging_cos": 0.0, "cogging_number": 60.0}
T = np.arange(0.0, 8.0, 0.001)
WIDTH_S = 0.008
"""Width of the filter [s]: one pass leaves 0.66 of the wave at 1.9 rad/s."""
W = 2.0 * np.pi / 3.0
"""Circular frequency [rad/s], so that the speed changes its sign in the middle between two rows."""
Q, V, A = (0.9 * W**k * np.sin(W * (T + 5e-4) + k * np.pi / 2.0) for k in range(3))


def torque(wave: float) -> Array:
    """Return the torque of the motion in closed form, with a wave over position of an amplitude [N m]."""
    of_friction = TRUTH["sigma2"] * V + TRUTH["Fc"] * np.sign(V)
    rigid = TRUTH["inertia"] * A + TRUTH["gravity_sin"] * np.sin(Q) + TRUTH["Ks"] * Q
    return rigid + of_friction + wave * np.sin(WAVE["cogging_number"] * Q)


def run(wave: float) -> Run:
    return Run(
        file="a", free_joints=(0,), t=T, u=torque(wave)[:, None], y=Q[:, None], hold="linear",
        noise=np.array([1e-6]), resolution=np.zeros(1), posture=np.zeros(0), use="fit",
    )  # fmt: skip


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x[400:-400] ** 2)))


def test_a_fast_wave_keeps_its_amplitude() -> None:
    cogging = catalogue()["cogging"].at(Scales())
    equations = joint_equations(0, effects=[cogging])
    turned = torque_run(run(WAVE["cogging_sin"]), WIDTH_S)
    simulator = TorqueSimulator.of(equations)

    def simulated(amplitude: float) -> Array:
        values = TRUTH | WAVE | {"cogging_sin": amplitude}
        theta = np.array([values[q.id] for q in simulator.equations.parameters])
        return np.asarray(simulator.simulate(theta, turned).y[:, 0])

    column = simulated(1.0) - simulated(0.0)
    left = turned.y[:, 0] - simulated(0.0)
    # One pass of the filter more on the measured wave than on the computed one took 0.22 of the amplitude.
    rows = slice(400, -400)
    assert column[rows] @ left[rows] / (column[rows] @ column[rows]) == pytest.approx(WAVE["cogging_sin"], rel=0.03)
    assert rms(left - WAVE["cogging_sin"] * column) < 0.1 * rms(WAVE["cogging_sin"] * column)


def test_dry_friction_turns_as_fast_as_the_measured_one() -> None:
    turned = torque_run(run(0.0), WIDTH_S)
    simulator = TorqueSimulator.of(joint_equations(0))
    theta = np.array([TRUTH[q.id] for q in simulator.equations.parameters])
    # A step that passes one filter less leaves a tenth of the friction at a reversal.
    left = (turned.y - simulator.simulate(theta, turned).y)[400:-400]
    assert np.abs(left).max() < 0.02 * TRUTH["Fc"]


def test_plain_columns_and_torques_along_a_motion_turn_alike() -> None:
    motion = filter_run(run(0.0), WIDTH_S)
    regressor = Regressor.of(None, (0,), (), (False,))
    plain = {"inertia": 0.02, "gravity_cos": 0.0, "gravity_sin": 0.3, "Fv": 0.05, "Fc": 0.08, "offset": 0.0}
    spring = TRUTH["Ks"] * motion.q[:, 0]
    columns = regressor.columns(motion)[:, 0] @ np.array([plain[id] for id in regressor.ids]) + spring
    equations = joint_equations(0)
    along = TorqueAlong.of(equations, regressor, (False,))
    computed = along.torque(np.array([TRUTH[q.id] for q in equations.parameters]), motion)[:, 0]
    for one in (columns, computed):
        assert np.abs(motion.torque[:, 0] - one)[400:-400].max() < 0.02 * TRUTH["Fc"]


def test_the_linear_part_is_inertia_viscous_friction_and_spring() -> None:
    equations = torque_equations(joint_equations(0))
    values = {q.symbol: TRUTH[q.id] for q in equations.parameters}
    q, v, a = (one.symbol for one in equations.inputs)
    linear = equations.outputs[1].expression.subs(values)
    assert float(linear.subs({q: 0.3, v: -0.7, a: 2.0})) == pytest.approx(0.02 * 2.0 - 0.05 * 0.7 + 0.1 * 0.3)


@pytest.mark.parametrize("key", ["configuration_inertia", "cogging", "gain_drift"])
def test_no_effect_has_a_linear_part_of_its_own(key: str) -> None:
    nominal = joint_equations(0)
    effect = catalogue()[key].at(Scales())
    alike = torque_equations(joint_equations(0, effects=[effect]), nominal=nominal)
    # A part of its own would be filtered less or more often than the model's that it is compared with.
    assert alike.outputs[1].expression == torque_equations(nominal).outputs[1].expression
