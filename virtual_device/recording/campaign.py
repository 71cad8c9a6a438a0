"""Campaigns of locked-joint tests, one free joint each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.virtual_device.machine.effects import Shape, resolve
from haptid.virtual_device.machine.friction import LAWS, law_number
from haptid.virtual_device.machine.joint import JOINT
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.simulate import complete, scales_of, simulate_joint
from haptid.virtual_device.recording.tables import RunTable, joint_columns, write_campaign

Effects = Mapping[str, float | Mapping[str, float]]
START_SPREAD = 0.4
"""A joint comes to rest within this share of the band in which Coulomb friction holds it against its spring."""


def joint_parameters(parameters: Mapping[str, float], runs: Sequence[Cosine], effects: Effects) -> dict[str, Any]:
    """Resolve sizes once for all runs, at the largest torque amplitude and the median frequency.

    Parameters
    ----------
    parameters
        Parameters of the joint by name, SI units.
    runs
        Torques of all runs.
    effects
        Disturbances: size, or parameters of ``joint.c``, by name.

    Returns
    -------
    dict
        Parameters that each disturbance sets, by its name.

    Raises
    ------
    InputError
        Where a parameter or a disturbance is unknown.
    NumericalError
        Where the joint has no stable rest.
    """
    torque = max(run.amplitude for run in runs)
    scales = scales_of(parameters, torque, float(np.median([run.frequency for run in runs])))
    return {name: resolve({name: size}, scales, Shape()) for name, size in effects.items()}


def joint_runs(
    joint: int,
    parameters: Mapping[str, float],
    inputs: Sequence[Cosine],
    *,
    effects: Effects | None = None,
    sensor: Sensor | None = None,
    hold: str = "zero",
    seed: int = 0,
) -> tuple[RunTable, ...]:
    """Simulate the locked-joint tests of one joint, as `simulate_joint` does each.

    Parameters
    ----------
    joint
        Number of the joint.
    parameters
        Parameters of the joint by name, SI units.
    inputs
        Torque of each run.
    effects
        Disturbances: size, or parameters of ``joint.c``, by name; the same in all runs.
    sensor
        Position sensor; that of `Sensor` where None.
    hold
        ``zero`` or ``linear``: torque between rows.
    seed
        Seed of starts, noise and scatter; each run has its own stream.

    Returns
    -------
    tuple of RunTable
        One run an input, in their order.

    Raises
    ------
    InputError
        Where a parameter or a disturbance is unknown.
    NumericalError
        Where the joint has no stable rest.
    """
    fixed = joint_parameters(parameters, inputs, effects or {})
    base = complete(parameters)
    disturbed = base | {k: v for values in fixed.values() for k, v in values.items() if k in JOINT.neutral()}
    rest, band = JOINT.rest_position(disturbed), START_SPREAD * base["Fc"] / base["Ks"]
    tables = []
    for number, run in enumerate(inputs):
        sequence = np.random.SeedSequence([seed, joint, number])
        start = rest + band * np.random.default_rng(sequence.spawn(1)[0]).uniform(-1, 1)
        t, torque = run.times(), run.torque()
        position = simulate_joint(
            base | {"q0": start},
            t,
            torque,
            effects=fixed,
            hold=hold,
            sensor=sensor or Sensor(),
            period=run.period,
            seed=sequence,
        )
        columns = joint_columns(joint, t, torque, position)
        name = f"joint{joint}_{number}_w{run.frequency:.4g}.csv.gz"
        tables.append(RunTable(file=name, free_joints=(joint,), columns=columns, use=run.use, reason=run.reason))
    return tuple(tables)


def header(title: str, device: str, sensor: Sensor, hold: str = "zero") -> dict[str, Any]:
    """Return the head of campaign.toml.

    Parameters
    ----------
    title
        Title of the campaign.
    device
        Name of a device, or its file.
    sensor
        Position sensor, told where its noise is white.
    hold
        ``zero`` or ``linear``: torque between rows.

    Returns
    -------
    dict
        Tables ``campaign`` and, where the noise is white and not 0, ``sensor``.
    """
    known = {"noise_rad": sensor.noise, "resolution_rad": sensor.resolution}
    head = {"title": title, "device": device, "measured": False, "hold": hold}
    return {"campaign": head} | ({"sensor": known} if sensor.noise > 0 and sensor.coloured == 0 else {})


def make_joint_campaign(  # noqa: PLR0913 - what a test bench sets, by keyword
    folder: Path,
    joint: int,
    parameters: Mapping[str, float],
    inputs: Sequence[Cosine],
    *,
    effects: Effects | None = None,
    sensor: Sensor | None = None,
    hold: str = "zero",
    seed: int = 0,
    device: str = "single_joint",
    known: Mapping[str, Mapping[str, float]] | None = None,
    title: str = "Synthetic locked-joint tests",
    friction: str = "lugre",
) -> Path:
    """Write a campaign of one joint.

    Parameters
    ----------
    folder
        Folder of the campaign.
    joint
        Number of the joint.
    parameters
        Parameters of the joint by name, SI units.
    inputs
        Torque of each run.
    effects
        Disturbances: size, or parameters of ``joint.c``, by name; the same in all runs.
    sensor
        Position sensor; that of `Sensor` where None.
    hold
        ``zero`` or ``linear``: torque between rows.
    seed
        Seed of starts, noise and scatter; each run has its own stream.
    device
        ``single_joint`` or ``freedom6s``.
    known
        What campaign.toml tells about the parameters, e.g. ``{"Ks": {"initial": 0.1}}``.
    title
        Title of the campaign.
    friction
        Law of the joint, one of `friction.LAWS`; campaign.toml names it where it is not LuGre.

    Returns
    -------
    Path
        The campaign.toml.

    Raises
    ------
    InputError
        Where a parameter, a disturbance or the law is unknown.
    NumericalError
        Where the joint has no stable rest, or its motion stops being finite.
    """
    sensor = sensor or Sensor()
    parameters = dict(parameters) | law_number(friction)
    runs = joint_runs(joint, parameters, inputs, effects=effects, sensor=sensor, hold=hold, seed=seed)
    head = header(title, device, sensor, hold)
    told: dict[str, Any] = {} if friction == LAWS[0] else {"friction": friction}
    if known:
        told["parameters"] = {name: dict(value) for name, value in known.items()}
    if told:
        head["joint"] = {str(joint): told}
    return write_campaign(folder, head, runs, joints=6 if device == "freedom6s" else 1)
