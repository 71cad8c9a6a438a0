"""Make the campaigns of the panel with the virtual device; no module here knows a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.recording.inputs import Cosine, rich
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import RunTable, joint_columns, write_campaign
from studies.hidden.plan import Case
from studies.hidden.run import write_case

JOINT = 3
DURATION_S, FITTED = 6.0, 3
"""Length of a run, and number of fitted runs; all three of `rich` that no fit sees are there as well."""
CONTROLLED_S, STEP_S = 8.0, 0.01
"""Length and row spacing of a run under position control."""
KP, KD, FILTER_S = 0.4, 0.03, 0.02
"""Gains of the controller [N m/rad, N m s/rad] and time constant of its velocity [s]."""


def make_free(folder: Path, *, seed: int, kind: str, effects: list[str], size: str) -> None:
    """Write a campaign of short runs that torque drives, as a blind study has them.

    Parameters
    ----------
    folder
        Of the campaign.
    seed
        Of joint, sizes and noise.
    kind, effects, size
        As in `studies.hidden.plan`.
    """
    case = Case(
        kind=kind, effects=tuple(effects), size=size, joint=JOINT, device="single_joint", inputs="rich", noise=2e-4,
        coloured=0.0, correlation_time=0.05, scatter=0.02,
    )  # fmt: skip
    write_case(folder, case, [seed, 1, 0], short_runs(case.joint))


def short_runs(joint: int) -> tuple[Cosine, ...]:
    """Shorten the rich inputs of a joint to `DURATION_S` each.

    Parameters
    ----------
    joint
        Number of the joint.

    Returns
    -------
    tuple of Cosine
        The first `FITTED` runs to fit, then all runs that no fit sees.
    """
    runs = rich(joint)
    chosen = [run for run in runs if run.use == "fit"][:FITTED] + [run for run in runs if run.use == "validate"]
    return tuple(replace(run, duration=DURATION_S) for run in chosen)


def make_controlled(folder: Path, *, seed: int, cogging: float) -> None:
    """Write a campaign of joint 0 under position control, two runs to fit and one that no fit sees.

    Parameters
    ----------
    folder
        Of the campaign.
    seed
        Of the noise.
    cogging
        Torque cogging·sin(5 q) [N m] that the recorded command does not hold.
    """
    tables = []
    for number, use in enumerate(("fit", "fit", "validate")):
        t, torque, position = _move(np.random.default_rng([seed, 2, number]), cogging)
        columns = joint_columns(0, t, torque, position)
        tables.append(RunTable(file=f"joint0_{number}.csv.gz", free_joints=(0,), columns=columns, use=use))
    campaign = {"title": "Synthetic joint under position control", "device": "single_joint", "measured": False}
    write_campaign(folder, {"campaign": campaign}, tables, joints=1)


def _move(rng: np.random.Generator, cogging: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Move joint 0 along three sines; return times [s], commanded torques [N m] and readings [rad], shape (n,)."""
    arm, sensor = Arm(read_truth()), Sensor(noise=2e-4)
    t = np.round(np.arange(0.0, CONTROLLED_S, STEP_S), 6)
    wanted = 0.25 * np.sin(1.1 * t) + 0.12 * np.sin(6.3 * t) + 0.01 * np.sin(2.9 * t)
    state, torque, read, velocity = arm.start(np.zeros(JOINTS)), np.zeros(t.size), np.zeros(t.size), 0.0
    for k in range(t.size):
        read[k] = state[0] + sensor.std * rng.standard_normal()
        if k:
            velocity += STEP_S / (STEP_S + FILTER_S) * ((read[k] - read[k - 1]) / STEP_S - velocity)
        torque[k] = KP * (wanted[k] - read[k]) - KD * velocity
        applied = np.zeros(JOINTS)
        applied[0] = torque[k] + cogging * np.sin(5.0 * state[0])
        arm.advance((0,), state, applied, STEP_S)
    return t, torque, read
