"""Write a synthetic campaign of the Freedom 6S: ``python -m virtual_device.make_campaign``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.support.command import exit_codes, parse_joints
from haptid.support.declaring.usage import OneLineCommand
from haptid.support.errors import InputError
from haptid.support.terminal import Count
from haptid.virtual_device.machine.arm import JOINTS, Arm
from haptid.virtual_device.machine.effects import parse_effects
from haptid.virtual_device.machine.friction import LAWS, parse_friction
from haptid.virtual_device.machine.truth import read_truth
from haptid.virtual_device.machine.variation import vary
from haptid.virtual_device.recording.campaign import header, joint_runs
from haptid.virtual_device.recording.inputs import COUPLED, rich, table3
from haptid.virtual_device.recording.planned import planned_runs, read_planned
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.recording.tables import RunTable, write_campaign
from haptid.virtual_device.recording.whole import Controller, Reference, controlled_run, coupled_test

EMBEDDED = Path(__file__).parent.parent / "measurement" / "campaigns" / "freedom6s"
"""The embedded campaign of the paper's protocol."""
PLANNED = EMBEDDED.parent / "freedom6s_planned"
"""The embedded campaign with tests in planned lock postures."""
PLAN = PLANNED / "locking_plan.json"
"""The postures of that campaign, as ``python -m model.plan --tests 10`` proposes them."""
TITLE = (
    "Freedom 6S, synthetic: locked-joint tests after Table III of Tam, Kubica and Wang (2005), from a virtual device"
)
TITLE_PLANNED = (
    "Freedom 6S, synthetic: locked-joint tests after Table III of Tam, Kubica and Wang (2005), and in planned lock "
    "postures, from a virtual device"
)
SMALL_SCATTER = 1e-4
"""Amplitude scatter of the tendon joints in the embedded campaign: about a sixth of the sensor's noise."""
TENDON = (3, 4, 5)
FRICTION = f"Friction law of all joints, or of some, the others having {LAWS[0]}: {', '.join(LAWS)}."


def joint_tests(
    arm: Arm,
    joint: int,
    effects: Mapping[str, float],
    *,
    scatter: float,
    sensor: Sensor,
    inputs: str,
    seed: int,
) -> tuple[RunTable, ...]:
    """Simulate the locked-joint tests of one joint with the others at home.

    Parameters
    ----------
    arm
        The machine.
    joint
        Number of the free joint.
    effects
        Disturbances by name with their sizes.
    scatter
        Relative standard deviation of the amplitude of a cycle, for the joints `TENDON`; not used where ``effects`` has
        one.
    sensor
        Position sensor.
    inputs
        ``table3``, or another word for `rich`.
    seed
        Seed of the random numbers.

    Returns
    -------
    tuple of RunTable
        One run a cosine.

    Raises
    ------
    InputError
        Where a disturbance is unknown.
    NumericalError
        Where the joint has no stable rest.
    """
    hidden: dict[str, float | Mapping[str, float]] = dict(effects)
    if joint in TENDON and scatter > 0 and "amplitude_scatter" not in hidden:
        hidden["amplitude_scatter"] = {"scatter": scatter}
    cosines = table3(joint) if inputs == "table3" else rich(joint)
    parameters = arm.locked_joint(joint, np.zeros(JOINTS))
    return joint_runs(joint, parameters, cosines, effects=hidden, sensor=sensor, seed=seed)


def _coupled(arm: Arm, number: int, sensor: Sensor, seed: int) -> tuple[RunTable, ...]:
    return (coupled_test(arm, number, sensor=sensor, seed=(seed, 100, number)),)


def _controlled(arm: Arm, number: int, sensor: Sensor, seed: int) -> tuple[RunTable, ...]:
    drawn = np.random.default_rng([7, number])
    reference = Reference(
        frequency=np.round(drawn.uniform(1.0, 3.0, JOINTS), 2), phase=np.round(drawn.uniform(-np.pi, np.pi, JOINTS), 2)
    )
    name = f"all_joints_{number}.csv.gz"
    return (controlled_run(arm, reference, Controller(), sensor=sensor, name=name, seed=(seed, 200, number)),)


@click.command(cls=OneLineCommand, help=__doc__)
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=EMBEDDED, help="Folder to write.")
@click.option("--effects", default=None, metavar="ID=SIZE,...", help="Disturbances of the single-joint tests.")
@click.option("--scatter", default=SMALL_SCATTER, show_default=True, help="Cycle amplitude scatter of joints 3, 4, 5.")
@click.option("--seed", type=int, default=1, show_default=True, help="Of noise, scatter and starts.")
@click.option("--noise", default=2e-4, show_default=True, help="White sensor noise [rad].")
@click.option("--resolution", default=1.5e-4, show_default=True, help="Encoder step [rad].")
@click.option("--coloured-noise", default=0.0, show_default=True, help="Added noise correlated over 0.1 s [rad].")
@click.option("--joints", default=None, metavar="4,5,3", help="Only these joints, each alone.")
@click.option("--inputs", type=click.Choice(["table3", "rich"]), default="table3", show_default=True)
@click.option("--friction", default=LAWS[0], metavar="LAW or J=LAW,...", show_default=True, help=FRICTION)
@click.option("--device-variation", default=0.0, show_default=True, help="Another machine, drawn within ± this share.")
@click.option("--plan", type=click.Path(path_type=Path), help="locking_plan.json: its postures are tested too.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
@exit_codes
def main(
    out: Path,
    effects: str | None,
    joints: str | None,
    *,
    plan: Path | None,
    quiet: bool,
    **settings: Any,
) -> None:
    """Simulate all runs and write the folder."""
    chosen, seed, width = parse_joints(joints), settings["seed"], settings["device_variation"]
    for joint in chosen or ():
        if joint not in range(JOINTS):
            raise InputError(where="--joints", expected="joints 0 to 5", got=str(joint))
    friction = parse_friction(settings["friction"], chosen or range(JOINTS))
    truth = replace(read_truth(), friction=friction)
    arm = Arm(vary(truth, width, np.random.default_rng([seed, 300])) if width > 0 else truth)
    sensor = Sensor(noise=settings["noise"], resolution=settings["resolution"], coloured=settings["coloured_noise"])
    known = {"scatter": settings["scatter"], "inputs": settings["inputs"]}
    test = partial(joint_tests, arm, sensor=sensor, seed=seed, **known)
    jobs = [partial(test, joint, parse_effects(effects)) for joint in chosen or range(JOINTS)]
    head = header(TITLE_PLANNED if plan else TITLE, "freedom6s", sensor)
    if friction:
        head["joint"] = {str(joint): {"friction": law} for joint, law in friction.items()}
    if chosen is None:
        jobs += [partial(_coupled, arm, number, sensor, seed) for number in range(len(COUPLED))]
        tests = enumerate(read_planned(plan) if plan else ())
        jobs += [partial(planned_runs, arm, test, number, sensor=sensor, seed=seed) for number, test in tests]
        jobs += [partial(_controlled, arm, number, sensor, seed) for number in range(2)]
        head["controller"] = Controller().described()
    runs = [run for job in Count(jobs, title="simulating", quiet=quiet) for run in job()]
    write_campaign(out, head, runs, joints=JOINTS)
    click.echo(
        f"{out}: {len(runs)} synthetic runs, {sum((out / run.file).stat().st_size for run in runs) / 1e6:.2f} MB"
    )


if __name__ == "__main__":
    main()
