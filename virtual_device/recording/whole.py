"""Runs of the arm with several joints free: the coupled test in open loop, and all six joints under a controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.compiled import Array
from haptid.virtual_device.recording.inputs import AMPLITUDE, COUPLED, Cosine
from haptid.virtual_device.recording.sensor import Sensor, cycle_factors
from haptid.virtual_device.recording.tables import RunTable

SCATTERING = 1
"""Of the random numbers of amplitudes that scatter, beside those of the sensor."""


def coupled_run(  # noqa: PLR0913 - what a user of a test bench sets, by keyword
    arm: Arm,
    cosines: Sequence[Cosine],
    joints: tuple[int, ...],
    *,
    sensor: Sensor,
    name: str,
    seed: Sequence[int],
    posture: Sequence[float] = (0.0,) * JOINTS,
    scatter: Mapping[int, tuple[float, bool]] | None = None,
) -> RunTable:
    """Drive some joints, each by its own cosine (held between rows), from rest; the others stay at a posture.

    Parameters
    ----------
    arm
        The machine.
    cosines
        Torque of each driven joint, all with the same times.
    joints
        Numbers of the driven joints.
    sensor
        Position sensor.
    name
        Name of the table.
    seed
        Seed of the random numbers.
    posture
        Positions of the others [rad], shape (6,).
    scatter
        By joint, the relative standard deviation of the amplitude of a cycle of its own torque, and whether the torque
        scatters; else the reading about the place of rest does.

    Returns
    -------
    RunTable
        The run, with the use of the first cosine.

    Raises
    ------
    NumericalError
        Where the arm has no rest in this posture.
    """
    t, rng, scatters = cosines[0].times(), np.random.default_rng(list(seed)), scatter or {}
    torque, factors = np.zeros((t.size, JOINTS)), np.ones((t.size, JOINTS))
    for joint, cosine in zip(joints, cosines, strict=True):
        torque[:, joint] = cosine.torque()
        if joint in scatters:
            own = np.random.default_rng([*seed, SCATTERING, joint])
            factors[:, joint] = cycle_factors(t, cosine.period, scatters[joint][0], own)
    on_torque = np.array([scatters.get(joint, (0.0, False))[1] for joint in range(JOINTS)])
    driven, rest = torque * np.where(on_torque, factors, 1.0), arm.rest(joints, np.array(posture))
    state = arm.start(rest)
    positions = np.empty((t.size, JOINTS))
    for k, step in enumerate([*np.diff(t), 0.0]):
        positions[k] = state[:JOINTS]
        if step > 0:
            arm.advance(joints, state, driven[k], float(step))
    positions = np.where(on_torque | (factors == 1.0), positions, rest + (positions - rest) * factors)
    columns: dict[str, Array] = {"time_s": t}
    for joint in joints:
        columns[f"torque_{joint}_Nm"] = torque[:, joint]
        columns[f"position_{joint}_rad"] = np.round(sensor.read(t, positions[:, joint], rng), 7)
    return RunTable(file=name, free_joints=joints, columns=columns, use=cosines[0].use)


def coupled_test(
    arm: Arm,
    number: int,
    *,
    sensor: Sensor,
    seed: Sequence[int],
    scatter: Mapping[int, tuple[float, bool]] | None = None,
) -> RunTable:
    """Make a run of the coupled test, `COUPLED`: joints 0 and 1 driven by cosines of their own.

    Parameters
    ----------
    arm
        The machine.
    number
        Number of the run in `COUPLED`.
    sensor
        Position sensor.
    seed
        Seed of the random numbers.
    scatter
        As in `coupled_run`.

    Returns
    -------
    RunTable
        The run.

    Raises
    ------
    NumericalError
        Where the arm has no rest at home.
    """
    frequencies, use = COUPLED[number]
    cosines = [Cosine(amplitude=AMPLITUDE[j], frequency=w, use=use) for j, w in enumerate(frequencies)]
    name = f"joints01_{number}_w{frequencies[0]:.4g}_{frequencies[1]:.4g}.csv.gz"
    return coupled_run(arm, cosines, (0, 1), sensor=sensor, name=name, seed=seed, scatter=scatter)


@dataclass(frozen=True, slots=True, kw_only=True)
class Controller:
    """Proportional-derivative control at every row: τ = Kp (r − y) − Kd v̂, v̂ a low-passed difference of readings.

    Parameters
    ----------
    proportional, derivative
        Gains Kp [N m/rad] and Kd [N m s/rad] of the six joints.
    filter_s
        Time constant of the low-pass filter of v̂ [s].
    """

    proportional: tuple[float, ...] = (0.30, 0.40, 0.30, 0.03, 0.03, 0.03)
    derivative: tuple[float, ...] = (0.02, 0.03, 0.02, 8e-4, 8e-4, 8e-4)
    filter_s: float = 0.02

    def described(self) -> dict[str, object]:
        """Describe the controller for campaign.toml.

        Returns
        -------
        dict
            Table ``[controller]``: law in words, gains and time constant in SI units.
        """
        return {
            "law": "torque = Kp (reference - position) - Kd velocity; velocity: low-passed difference of positions",
            "Kp_Nm_per_rad": list(self.proportional),
            "Kd_Nms_per_rad": list(self.derivative),
            "filter_time_constant_s": self.filter_s,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Smooth motion r = rest + s(t) A sin(ω t + φ), s rising from 0 to 1 over two seconds.

    Parameters
    ----------
    amplitude
        A [rad], shape (6,).
    frequency
        ω [rad/s], shape (6,).
    phase
        φ [rad], shape (6,).
    """

    amplitude: Array = field(default_factory=lambda: np.array([0.15, 0.12, 0.15, 0.25, 0.25, 0.20]))
    frequency: Array
    phase: Array

    def at(self, t: Array, rest: Array) -> Array:
        """Return the reference at some times.

        Parameters
        ----------
        t
            Times [s], shape (n,).
        rest
            Rest position [rad], shape (6,).

        Returns
        -------
        Array
            Positions [rad], shape (n, 6).
        """
        share = np.clip(t / 2.0, 0.0, 1.0)[:, None]
        rise = share**3 * (10 - 15 * share + 6 * share**2)
        wave = self.amplitude * np.sin(np.outer(t, self.frequency) + self.phase)
        return np.asarray(np.round(rest + rise * wave, 6))


def controlled_run(
    arm: Arm, reference: Reference, controller: Controller, *, sensor: Sensor, name: str, seed: Sequence[int]
) -> RunTable:
    """Move all six joints along a reference for 10 s; the recorded torque is what the controller commanded.

    Parameters
    ----------
    arm
        The machine.
    reference
        Wanted motion.
    controller
        Gains of the controller.
    sensor
        Position sensor.
    name
        Name of the table.
    seed
        Seed of the random numbers.

    Returns
    -------
    RunTable
        Torques, readings and references of all joints, for validation.

    Raises
    ------
    NumericalError
        Where the arm has no rest at home.
    """
    t, joints = np.round(np.arange(2001) * 0.005, 6), tuple(range(JOINTS))
    rng, rest = np.random.default_rng(list(seed)), arm.rest(joints, np.zeros(JOINTS))
    wanted, state = reference.at(t, rest), arm.start(rest)
    Kp, Kd = np.array(controller.proportional), np.array(controller.derivative)
    torque, read, velocity = np.empty((t.size, JOINTS)), np.empty((t.size, JOINTS)), np.zeros(JOINTS)
    for k in range(t.size):
        read[k] = np.round(sensor.read(t[:2], state[:JOINTS], rng), 7)
        if k:
            step = float(t[k] - t[k - 1])
            velocity += step / (step + controller.filter_s) * ((read[k] - read[k - 1]) / step - velocity)
        torque[k] = np.round(Kp * (wanted[k] - read[k]) - Kd * velocity, 8)
        if k + 1 < t.size:
            arm.advance(joints, state, torque[k], float(t[k + 1] - t[k]))
    columns: dict[str, Array] = {"time_s": t}
    for j in joints:
        columns |= {f"torque_{j}_Nm": torque[:, j], f"position_{j}_rad": read[:, j], f"reference_{j}_rad": wanted[:, j]}
    return RunTable(
        file=name, free_joints=joints, columns=columns, use="validate", note="closed loop: see [controller]"
    )
