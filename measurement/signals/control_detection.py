"""Tell runs recorded in open loop from those whose torque a controller made from the measured position."""

from __future__ import annotations

import numpy as np

from haptid.measurement.signals.noise import contrasts, robust_std
from haptid.measurement.values.run import Array, Run

STEADY = 0.95
"""Share of moving rows at one speed, from which a motion counts as a prescribed sweep."""
COMMANDED = 3e-4
"""Noise of a torque over its range, below which it counts as a command rather than what a controller answered."""
LINKED = 0.3
"""Correlation of the torque's and the position's noise, from which the torque counts as made from the position."""
LAGS = 3


def position_control(run: Run, column: int = 0) -> str:
    """Say in a few words why a run looks recorded under position control; empty where it does not.

    Three signs are looked for: a recorded reference position; a sweep at constant speed by a torque that is no smooth
    command (a slow cosine can move a viscous joint at nearly constant speed); and torque whose high-frequency part is
    the position's noise times a gain (a commanded torque knows nothing of the sensor's noise). The last is the
    correlation of fourth divided differences of u and y, up to three rows of delay.
    """
    joint = run.free_joints[column]
    if any(name in run.extra for name in (f"reference_{joint}_rad", f"reference_{joint}_m")):
        return "a reference position is recorded"
    if steady_share(run.t, run.y[:, column]) > STEADY and not is_commanded(run, column):
        return "position sweeps at constant speed"
    if noise_link(run, column) > LINKED:
        return "torque follows the position's noise"
    return ""


def is_commanded(run: Run, column: int) -> bool:
    """Whether the torque is as smooth as a command: its noise is rounding."""
    return robust_std(contrasts(run.t, run.u[:, column], 4)) < COMMANDED * float(np.ptp(run.u[:, column]))


def steady_share(t: Array, y: Array) -> float:
    """Share of the moving rows whose speed is within 15 % of the median speed.

    Speeds are taken over 1/50 of the run, and rows slower than a tenth of the fastest count as standing.
    """
    span = max(t.size // 50, 1)
    speed = np.abs((y[span:] - y[:-span]) / (t[span:] - t[:-span]))
    moving = speed[speed > 0.1 * speed.max()] if speed.size and speed.max() > 0 else speed[:0]
    if moving.size < 10:
        return 0.0
    usual = float(np.median(moving))
    return float(np.mean(np.abs(moving - usual) < 0.15 * usual))


def noise_link(run: Run, column: int, order: int = 4) -> float:
    """Largest correlation between the high-frequency parts of torque and position, over delays of 0 to 3 rows."""
    u = contrasts(run.t, run.u[:, column], order)
    y = contrasts(run.t, run.y[:, column], order)
    if robust_std(u) < 1e-6 * max(float(np.ptp(run.u[:, column])), 1e-300) or robust_std(y) == 0:
        return 0.0
    u = np.clip(u / robust_std(u), -3, 3)
    y = np.clip(y / robust_std(y), -3, 3)
    pairs = [(u[lag:], y[: y.size - lag]) for lag in range(LAGS + 1)]
    return max(abs(float(np.mean(a * b) / np.sqrt(np.mean(a**2) * np.mean(b**2)))) for a, b in pairs)
