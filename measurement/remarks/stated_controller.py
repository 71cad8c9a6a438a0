"""Compare a recorded command with that of the stated controller: `Campaign` in, a sentence by file and joint out.

A joint with a controller is simulated through it, from the recorded reference, and the recorded command plays no part:
where it was recorded too, it shows whether the stated gains are in its unit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from haptid.measurement.format.drive_columns import COMMANDS
from haptid.measurement.signals.smoothing import smooth
from haptid.measurement.thresholds import THRESHOLDS
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.drive import Controller, Drive
from haptid.model.joint.drive_terms import (
    COMMAND_UNITS,
    DERIVATIVE_GAIN,
    ENABLED,
    GAIN,
    INTEGRAL_GAIN,
    LIMIT,
    REFERENCE,
    torque_along,
)
from haptid.support.linear_algebra import rms


@dataclass(frozen=True, slots=True, kw_only=True)
class Followed:
    """Say how the recorded command of a joint follows that of the stated controller.

    Parameters
    ----------
    factor
        Stated over recorded command [1], by their standard deviations.
    correlation
        Correlation of the two [1].
    """

    factor: float
    correlation: float


def find_other_controllers(campaign: Campaign) -> dict[tuple[str, int], str]:
    """Find joints whose recorded command is not that of their stated controller.

    Parameters
    ----------
    campaign
        As it was read; only fitted runs of a joint alone count, as only they are simulated through its controller.

    Returns
    -------
    dict
        A sentence by file and joint, for the first fitted run of each such joint.

    Notes
    -----
    The stated law is evaluated along the recorded reference and position. Rows in which the stated or the recorded
    command is saturated are left out, and so are those in which the motor is let go.
    """
    found = {}
    for joint, drive in campaign.drives.items():
        runs = [run for run in campaign.runs_of((joint,), "fit") if _recorded(run, drive, campaign) is not None]
        if drive.controller is None or not runs:
            continue
        followed = _compare(runs, drive, campaign)
        sentence = _tell(followed, drive, runs[0], campaign.torque_constants.get(joint)) if followed else ""
        if sentence:
            found[runs[0].file, joint] = sentence
    return found


def with_recorded_torques(campaign: Campaign) -> Campaign:
    """Put recorded torques in place of those that a stated controller gives along the measured motion.

    A remark on the torque of a run speaks of what was recorded: the torque of a controller that is not that of the runs
    may do the opposite.

    Parameters
    ----------
    campaign
        As it was read.

    Returns
    -------
    Campaign
        The same where no controller is stated, or no torque was recorded beside one.
    """
    return campaign.but(runs=tuple(_with_recorded_torque(run, campaign) for run in campaign.runs))


def difference_from_recorded(run: Run, campaign: Campaign) -> float | None:
    """Return how far the torque of the stated controller is from the recorded one.

    Parameters
    ----------
    run
        Run of one joint with a stated controller.
    campaign
        As it was read.

    Returns
    -------
    float or None
        RMS of stated − recorded over that of the recorded torque [1], over the rows in which neither is saturated and
        the motor is held; None where no torque was recorded beside the controller.
    """
    recorded = _recorded_torque(run, campaign)
    if recorded is None:
        return None
    drive = campaign.drives[run.free_joints[0]]
    below = np.abs(recorded) < (1.0 - THRESHOLDS.margin_of_saturation) * np.abs(recorded).max()
    differences = []
    for smoothed in (False, True):
        stated, rows = _stated(run, drive, smoothed=smoothed)
        rows = rows & below
        size = rms(recorded[rows]) if rows.any() else 0.0
        differences.append(rms((stated - recorded)[rows]) / size if size > 0.0 else 0.0)
    return min(differences)


def _with_recorded_torque(run: Run, campaign: Campaign) -> Run:
    recorded = _recorded_torque(run, campaign)
    return run if recorded is None else run.but(u=(recorded * run.drive_inputs[ENABLED])[:, None])


def _recorded_torque(run: Run, campaign: Campaign) -> Array | None:
    """Return the torque that was recorded beside a controller whose command it is; None where there is none."""
    drive = campaign.drives.get(run.free_joints[0])
    if len(run.free_joints) > 1 or drive is None or drive.controller is None or not drive.commands_torque:
        return None
    recorded = _recorded(run, drive, campaign)
    return recorded if recorded is not None and np.isfinite(recorded).all() else None


def _recorded(run: Run, drive: Drive, campaign: Campaign) -> Array | None:
    """Return the command as it was recorded, in the drive's unit; None where it was not."""
    (joint,) = run.free_joints
    torque = f"force_{joint}_N" if run.prismatic[0] else f"torque_{joint}_Nm"
    column = run.extra.get(COMMANDS.get(drive.kind, torque).format(joint=joint))
    current, constant = run.extra.get(f"current_{joint}_A"), campaign.torque_constants.get(joint)
    if column is None and drive.kind == "torque" and current is not None and constant is not None:
        return constant * current
    return column


def _compare(runs: list[Run], drive: Drive, campaign: Campaign) -> Followed | None:
    """Compare the commands over all runs; the best of the delays and of the speeds that a firmware may use counts."""
    controller = drive.controller
    recorded = [(run, column) for run in runs if (column := _recorded(run, drive, campaign)) is not None]
    below = [np.abs(c) < (1.0 - THRESHOLDS.margin_of_saturation) * np.nanmax(np.abs(c)) for _, c in recorded]
    tried = []
    for smoothed in (False, True) if controller and controller.derivative_gain else (False,):
        stated = [_stated(run, drive, smoothed=smoothed) for run, _ in recorded]
        for delay in range(THRESHOLDS.longest_controller_delay_rows + 1):
            pairs = []
            for (command, rows), (_, column), inside in zip(stated, recorded, below, strict=True):
                end = column.size - delay
                if end < THRESHOLDS.least_differences_of_noise:
                    continue
                kept = rows[:end] & rows[delay:] & inside[delay:] & np.isfinite(column[delay:])
                pairs.append((command[:end][kept], column[delay:][kept]))
            tried.append(_follow([s for s, _ in pairs], [r for _, r in pairs]))
    known = [one for one in tried if one is not None]
    return max(known, key=lambda one: one.correlation, default=None)


def _follow(stated: list[Array], recorded: list[Array]) -> Followed | None:
    """Return factor and correlation, None where too few rows or none that moves say something."""
    s, r = (np.concatenate([np.zeros(0), *columns]) for columns in (stated, recorded))
    if s.size < THRESHOLDS.least_differences_of_noise or np.std(s) == 0 or np.std(r) == 0:
        return None
    return Followed(factor=float(np.std(s) / np.std(r)), correlation=float(np.corrcoef(s, r)[0, 1]))


def _stated(run: Run, drive: Drive, *, smoothed: bool) -> tuple[Array, NDArray[np.bool_]]:
    """Return the command of the stated controller along a run, and the rows in which it is not saturated."""
    controller = drive.controller or Controller(kind="p", gain=1.0, limit=np.inf)
    inputs = {name: run.drive_inputs[name] for name in (REFERENCE, ENABLED, GAIN)}
    differenced = np.gradient(run.y[:, 0], run.t) if run.v is None else run.v[:, 0]
    speed = smooth(run).v if smoothed else differenced
    values = {
        LIMIT: np.inf,
        DERIVATIVE_GAIN: controller.derivative_gain,
        INTEGRAL_GAIN: controller.integral_gain,
    }
    # A command is the torque of a drive whose command is its torque.
    law = Drive(kind="torque", controller=replace(controller, limit=np.inf))
    command = torque_along(law, values, inputs, run.y[:, 0], speed, run.t)
    within = np.abs(command) < (1.0 - THRESHOLDS.margin_of_saturation) * controller.limit
    return command, within & (inputs[ENABLED] > 0)


def _tell(followed: Followed, drive: Drive, run: Run, constant: float | None) -> str:
    """Return a sentence where the recorded command is not the stated one; empty where it is, or may be."""
    factor, correlation = followed.factor, followed.correlation
    (joint,), slides = run.free_joints, run.prismatic[0]
    what = ("force" if slides else "torque") if drive.kind == "torque" else drive.kind
    if correlation < THRESHOLDS.largest_correlation_of_other_controller:
        return (
            f"the stated controller is not the one of these runs: the recorded {what} does not follow it "
            f"(correlation {correlation:.2f}); state that of these runs, or leave [joint.{joint}.controller] out"
        )
    most = THRESHOLDS.largest_factor_of_stated_controller
    if correlation < THRESHOLDS.least_correlation_of_stated_controller or 1.0 / most <= factor <= most:
        return ""
    return (
        f"the stated controller gives {factor:.3g} times the recorded {what}, which follows it "
        f"(correlation {correlation:.2f}): {_ask_for_unit(factor, drive, run, constant)}"
    )


def _ask_for_unit(factor: float, drive: Drive, run: Run, constant: float | None) -> str:
    """Return what to do about gains in another unit than the drive's."""
    (joint,), slides = run.free_joints, run.prismatic[0]
    length, kind = "m" if slides else "rad", f'[joint.{joint}.drive] kind = "current"'
    if drive.kind != "torque":
        unit = COMMAND_UNITS[drive.kind]
        return f"the output of this drive's controller is in {unit}: are its gains in {unit}/{length}?"
    off = THRESHOLDS.largest_difference_from_torque_constant
    if constant is not None and abs(factor * abs(constant) - 1.0) < off:
        key = "force_constant_N_per_A" if slides else "torque_constant_Nm_per_A"
        state = f"put {kind}, torque_constant = {constant:g} in place of that key"
        return f"1/{key}; are its gains in A/{length}? then {state}"
    return f"are its gains in A/{length}, not in {'N' if slides else 'N m'}/{length}? then state {kind}"
