"""Whether a run was recorded under position control is asked of what was commanded."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.measurement.signals.control_detection import position_control
from haptid.measurement.values.run import Run

NOISE, RATE = 3e-4, 500.0


def driven(kind: str, *, feedback: float) -> Run:
    """Return a run whose torque lacks the voltage that the measured speed induces; the command may feed noise back."""
    t = np.arange(4000) / RATE
    rng = np.random.default_rng(0)
    y = np.sin(2.0 * t) + NOISE * rng.standard_normal(t.size)
    command = 0.5 * np.cos(2.3 * t) + feedback * (np.sin(2.0 * t) - y)
    u = 0.05 * (command - 0.05 * np.gradient(y, t)) / 2.0
    return Run(
        file="a.csv", free_joints=(0,), t=t, u=u[:, None], y=y[:, None], noise=np.array([NOISE]),
        resolution=np.zeros(1), posture=np.zeros(0), use="fit",
        drive_inputs={kind: command, "enabled": np.ones(t.size)},
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["voltage", "duty"])
def test_a_command_in_open_loop_is_no_control_though_its_torque_follows_the_measured_speed(kind: str):
    assert position_control(driven(kind, feedback=0.0)) == ""
    without_command = driven(kind, feedback=0.0).but(drive_inputs={})
    assert position_control(without_command) == "torque follows the position's noise"


def test_a_voltage_that_feeds_the_position_back_is_control():
    assert position_control(driven("voltage", feedback=20.0)) == "torque follows the position's noise"
