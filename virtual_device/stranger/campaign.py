"""Campaigns of locked-joint tests of the stranger's joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.recording.campaign import START_SPREAD
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.tables import RunTable, joint_columns, write_campaign
from haptid.virtual_device.stranger.physics import LAWS, STRANGER, integrate
from haptid.virtual_device.stranger.readings import Recorder


def numbered(joint: Mapping[str, Any]) -> dict[str, float]:
    """Return parameters with the friction law by its number.

    Parameters
    ----------
    joint
        Parameters of ``stranger.c`` by name, SI units; ``law`` by its name.

    Returns
    -------
    dict
        Parameters as `integrate` takes them.
    """
    return {**joint, "law": float(LAWS.index(joint["law"]))}


def positions(joint: Mapping[str, Any], runs: Sequence[Cosine], max_step: float) -> Array:
    """Simulate runs without noise.

    Parameters
    ----------
    joint
        Parameters of ``stranger.c`` by name, SI units; ``law`` by its name.
    runs
        Runs.
    max_step
        Longest integration step [s].

    Returns
    -------
    ndarray, shape (n,)
        Every fourth noise-free reading [rad], one run after another, each from rest.

    Raises
    ------
    NumericalError
        Where the joint has no stable rest, or runs away.
    """
    parameters = numbered(joint)
    start = STRANGER.rest_position(parameters)
    made = [integrate(parameters, run.times(), run.torque(), start, max_step)[2] for run in runs]
    return np.concatenate([readings[::4] for readings in made])


def stranger_runs(
    number: int, joint: Mapping[str, Any], inputs: Sequence[Cosine], recorder: Recorder, seed: int
) -> tuple[RunTable, ...]:
    """Simulate and read the locked-joint tests of one joint.

    Parameters
    ----------
    number
        Number of the joint.
    joint
        Parameters of ``stranger.c`` by name, SI units; ``law`` by its name.
    inputs
        Torque of each run.
    recorder
        Sensor and recorder.
    seed
        Seed of starts and noise; each run has its own stream.

    Returns
    -------
    tuple of RunTable
        One run an input, in their order.

    Raises
    ------
    NumericalError
        Where the joint has no stable rest, or runs away.
    """
    parameters, tables = numbered(joint), []
    rest, band = STRANGER.rest_position(parameters), START_SPREAD * parameters["Fc"] / parameters["Ks"]
    for k, run in enumerate(inputs):
        rng, t, torque = np.random.default_rng([seed, k]), run.times(), run.torque()
        start = rest + band * rng.uniform(-1, 1)
        _, velocity, reading = integrate(parameters, t, torque, start)
        columns = joint_columns(number, t, torque, recorder.read(t, reading, velocity, rng))
        name = f"joint{number}_{k}_w{run.frequency:.4g}.csv.gz"
        tables.append(RunTable(file=name, free_joints=(number,), columns=columns, use=run.use, reason=run.reason))
    return tuple(tables)


def make_stranger_campaign(
    folder: Path,
    number: int,
    runs: Sequence[RunTable],
    *,
    device: str,
    known: Mapping[str, Mapping[str, float]],
    noise: Mapping[str, float],
) -> Path:
    """Write a campaign of one joint; it says nothing of the friction law.

    Parameters
    ----------
    folder
        Folder of the campaign.
    number
        Number of the joint.
    runs
        Runs, as `stranger_runs` returns them.
    device
        ``single_joint`` or ``freedom6s``.
    known
        What campaign.toml tells about the parameters, e.g. ``{"Ks": {"initial": 0.1}}``.
    noise
        Entries of ``[sensor]``; nothing is stated where empty.

    Returns
    -------
    Path
        The campaign.toml.
    """
    title = f"Synthetic blind case {folder.name}"
    head: dict[str, Any] = {"campaign": {"title": title, "device": device, "measured": False, "hold": "zero"}}
    if noise:
        head["sensor"] = dict(noise)
    if known:
        head["joint"] = {str(number): {"parameters": {name: dict(value) for name, value in known.items()}}}
    return write_campaign(folder, head, runs, joints=6 if device == "freedom6s" else 1)
