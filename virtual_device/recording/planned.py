"""Tests in other lock postures, as the file locking_plan.json asks for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from haptid.support.errors import InputError
from haptid.support.files.files import read_json
from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.recording.inputs import AMPLITUDE, Cosine
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import RunTable
from haptid.virtual_device.recording.whole import coupled_run

RUNS = ((1.0, 1.00, "fit"), (0.8, 1.45, "fit"), (1.1, 1.80, "fit"), (0.9, 1.25, "validate"))
"""Share of the amplitude of Table III, frequency of the first free joint [rad/s], and use of the runs of one test."""
APART = 0.73
"""Frequency of each further free joint over that of the one before."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedTest:
    """Test that a locking plan proposes.

    Parameters
    ----------
    free_joints
        Numbers of the joints that move.
    posture
        Positions of the locked joints [rad], shape (6,).
    """

    free_joints: tuple[int, ...]
    posture: tuple[float, ...]


def read_planned(path: Path) -> tuple[PlannedTest, ...]:
    """Read the proposed postures of a locking_plan.json.

    Parameters
    ----------
    path
        File locking_plan.json.

    Returns
    -------
    tuple of PlannedTest
        Tests in the order of the plan.

    Raises
    ------
    InputError
        Where the file has no such tests, or they are not of six joints.
    """
    plan = read_json(path, "a locking_plan.json", ("haptid.virtual_device.recording", "locking_plan.schema.json"))
    tests = [PlannedTest(free_joints=tuple(e["free_joints"]), posture=_posture(e)) for e in plan["postures"]["tests"]]
    for test in tests:
        if not set(test.free_joints) < set(range(JOINTS)) or len(test.posture) != JOINTS:
            raise InputError(
                str(path), expected=f"tests of a device with {JOINTS} joints", got=f"joints {test.free_joints}"
            )
    return tuple(tests)


def _posture(entry: dict[str, Sequence[float]]) -> tuple[float, ...]:
    return tuple(map(float, entry["locked_positions_rad"]))


def planned_runs(arm: Arm, test: PlannedTest, number: int, *, sensor: Sensor, seed: int) -> tuple[RunTable, ...]:
    """Simulate one planned test: three runs to fit and one to validate, every free joint at a frequency of its own.

    Parameters
    ----------
    arm
        The machine.
    test
        Free joints and posture of the locked ones.
    number
        Number of the test, in the names of the files.
    sensor
        Position sensor.
    seed
        Seed of the noise.

    Returns
    -------
    tuple of RunTable
        Four runs with the posture of the test.

    Raises
    ------
    NumericalError
        Where the arm has no rest in this posture.
    """
    made = []
    for k, (share, frequency, use) in enumerate(RUNS):
        cosines = [
            Cosine(amplitude=round(share * AMPLITUDE[j], 8), frequency=round(frequency * APART**place, 3), use=use)
            for place, j in enumerate(test.free_joints)
        ]
        joints = "".join(map(str, test.free_joints))
        run = coupled_run(
            arm,
            cosines,
            test.free_joints,
            sensor=sensor,
            name=f"planned{number:02d}_joints{joints}_{k}.csv.gz",
            seed=(seed, 400, number, k),
            posture=test.posture,
        )
        made.append(replace(run, posture=test.posture))
    return tuple(made)
