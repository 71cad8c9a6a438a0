"""Detect position control: `Run` in, the sign of a controller in words out, empty for open-loop runs."""

from __future__ import annotations

import numpy as np

from haptid.measurement.signals.noise import ORDER_OF_NOISE, contrasts, robust_std, shows_noise
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array, Run
from haptid.model.joint.drive_terms import COMMAND_UNITS


def position_control(run: Run, column: int = 0) -> str:
    """Name the sign by which a run looks recorded under position control.

    Parameters
    ----------
    run
        Run of any use.
    column
        Column of the joint among ``run.free_joints``.

    Returns
    -------
    str
        The first sign found, in a few words; empty for an open-loop run.

    Notes
    -----
    Three signs are looked for, in this order:

    1. a recorded reference position;
    2. a sweep at constant speed by a torque that is no smooth command (a slow cosine can move a viscous joint at nearly
       constant speed);
    3. torque whose high-frequency part is the position's noise times a gain: the correlation of fourth divided
       differences of u and y, up to three rows of delay, with recorded and with even time stamps. A commanded torque is
       independent of the sensor's noise. Of a motor driven by voltage or duty the recorded command is looked at: the
       torque that it makes follows the measured speed.
    """
    joint = run.free_joints[column]
    if any(name in run.extra for name in (f"reference_{joint}_rad", f"reference_{joint}_m")):
        return "a reference position is recorded"
    if is_steady_sweep(run, column) and not is_commanded(run, column):
        return "position sweeps at constant speed"
    if noise_link(run, column) > THRESHOLDS.least_noise_correlation_of_feedback:
        return "torque follows the position's noise"
    return ""


def is_steady_sweep(run: Run, column: int) -> bool:
    """Return whether a joint moves at one speed in nearly all rows in which it moves.

    Parameters
    ----------
    run
        Run of one or several free joints.
    column
        Index of the joint in the run.

    Returns
    -------
    bool
        True if the share of steady rows exceeds `least_share_of_steady_rows`.
    """
    return steady_share(run.t, run.y[:, column]) > THRESHOLDS.least_share_of_steady_rows


def is_commanded(run: Run, column: int) -> bool:
    """Return whether a torque is as smooth as a command: its noise is a small share of its range.

    Parameters
    ----------
    run
        Run of one or several free joints.
    column
        Index of the joint in the run.

    Returns
    -------
    bool
        True if noise over range is below `largest_noise_of_command_over_range`.
    """
    command = _command(run, column)
    noise = robust_std(contrasts(run.t, command, ORDER_OF_NOISE))
    return noise < THRESHOLDS.largest_noise_of_command_over_range * float(np.ptp(command))


def _command(run: Run, column: int) -> Array:
    """Return what the drive of a joint was commanded, shape (n_t,): what was recorded of it, else its torque."""
    recorded = (run.drive_inputs[kind] for kind in COMMAND_UNITS if kind in run.drive_inputs)
    return next(recorded, run.u[:, column])


def steady_share(t: Array, y: Array) -> float:
    """Return the share of the moving rows whose speed is within 15 % of the median speed.

    Parameters
    ----------
    t, y
        Time [s] and position in any unit, shape (n_t,).

    Returns
    -------
    float
        From 0 to 1; 0 where fewer than 10 rows move.

    Notes
    -----
    Speeds are differences over 1/50 of the rows. Rows slower than a tenth of the fastest count as at rest.
    """
    span = max(t.size // 50, 1)
    speed = np.abs((y[span:] - y[:-span]) / (t[span:] - t[:-span]))
    moving = speed[speed > 0.1 * speed.max()] if speed.size and speed.max() > 0 else speed[:0]
    if moving.size < 10:
        return 0.0
    usual = float(np.median(moving))
    return float(np.mean(np.abs(moving - usual) < 0.15 * usual))


def noise_link(run: Run, column: int, order: int = ORDER_OF_NOISE) -> float:
    """Return the largest correlation between the noise of torque and position, over delays of 0 to 3 rows.

    Parameters
    ----------
    run
        Run of any use.
    column
        Column of the joint among ``run.free_joints``.
    order
        Order of the divided differences that remove the motion from both (`contrasts`).

    Returns
    -------
    float
        Absolute correlation, 0 to 1; 0 where torque or position has no noise, and where so few rows a period were
        recorded that the differences hold motion, which any torque is linked with.
    """
    if not shows_noise(run.t, run.y[:, column]):
        return 0.0
    # Both signals are read at one time, so that an error of the time stamps alone links what moves fast. Such an error
    # is gone on even stamps; rows that were really taken unevenly have it there. A controller links them by either.
    return min(_link(t, _command(run, column), run.y[:, column], order) for t in (run.t, even_times(run.t)))


def even_times(t: Array) -> Array:
    """Return times at even intervals from the first row to the last.

    Parameters
    ----------
    t
        Times of the rows, shape (n_t,).

    Returns
    -------
    ndarray, shape (n_t,)
    """
    return np.linspace(t[0], t[-1], t.size)


def _link(t: Array, torque: Array, position: Array, order: int) -> float:
    """Return the largest correlation of `noise_link` on one choice of time stamps."""
    u, y = contrasts(t, torque, order), contrasts(t, position, order)
    if robust_std(u) < 1e-6 * max(float(np.ptp(torque)), 1e-300) or robust_std(y) == 0:
        return 0.0
    # Steps in a torque and stray readings would decide the correlation alone: both are limited to 3 deviations.
    u = np.clip(u / robust_std(u), -3, 3)
    y = np.clip(y / robust_std(y), -3, 3)
    pairs = [(u[lag:], y[: y.size - lag]) for lag in range(THRESHOLDS.longest_controller_delay_rows + 1)]
    return max(abs(float(np.mean(a * b) / np.sqrt(np.mean(a**2) * np.mean(b**2)))) for a, b in pairs)
