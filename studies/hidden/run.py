"""Make blind cases: campaigns in which something may be hidden, and the answers in a file apart.

``python -m studies.hidden.run --out DIR --cases N --seed S`` writes ``DIR/cases/case_0000/`` and so on, and
``DIR/labels.json``, which only the scorer opens. ``--extra case_0003 --amplitude … --frequency … --to FOLDER`` adds a
run to a copy of a case that is there, as an experiment asked for afterwards would.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.support.command import exit_codes
from haptid.support.errors import InputError, NumericalError
from haptid.virtual_device.machine.effects import Scales, Shape
from haptid.virtual_device.machine.joint import BASE, JOINT
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from studies.hidden.further_run import add_run
from studies.hidden.joints import choose_inputs, draw_joint, fixed_parameters
from studies.hidden.plan import KINDS, RANDOM, SIZES, UPRIGHT, Case, plan
from studies.hidden.sizing import Reach, formula, marked_size, reach, share_size, threshold_size
from studies.hidden.stranger import make_stranger_cases
from studies.hidden.writing import write_cases

DRAWS = 5
"""How often a case is drawn before its joint may be said to run away."""
MOST_OF_MOTION, HIDDEN = 0.3, 0.08
"""Largest share of the motion that a disturbance may be; what a refit leaves of it, over the noise, at least."""


def _size(case: Case, base: Reach, name: str, shape: Shape, rng: np.random.Generator) -> tuple[dict[str, float], float]:
    """Return the parameters of the hidden effect at the size that the case asks for, and what a refit leaves of it.

    What a refit leaves need not grow with the size; where it leaves nothing of a size, that is no case.
    """
    runs = base.runs
    torque, frequency = max(run.amplitude for run in runs), float(np.median([run.frequency for run in runs]))
    rest = JOINT.rest_position(base.parameters)
    effect = formula(name, Scales.of(base.parameters, torque, frequency, rest), shape)
    std = Sensor(noise=case.noise).std
    low = high = 0.0
    if case.size != "nominal":
        low = threshold_size(base, effect, float(rng.uniform(0.1, 0.3)) * std)
    if case.size != "threshold":
        high = marked_size(base, effect, float(rng.uniform(0.01, 0.05)), 2.0 * std)
    size = {"nominal": high, "small": float(np.sqrt(low * high)), "threshold": low}[case.size]
    if base.share(base.effect(effect(size))) > MOST_OF_MOTION:
        size = share_size(base, effect, MOST_OF_MOTION)
    left = base.left(base.effect(effect(size)))
    if left < HIDDEN * std:
        msg = f"{name}: the joint's own parameters take up all of it that a real machine could have"
        raise NumericalError(msg)
    return effect(size), left


def _scatter(case: Case, base: Reach, shape: Shape) -> dict[str, float]:
    spread = float(np.std(base.motion))
    least = 0.5 * Sensor(noise=case.noise).std / spread
    size = {"nominal": case.scatter, "small": float(np.sqrt(case.scatter * least)), "threshold": least}[case.size]
    return {"scatter": size, "scatter_on_torque": float(shape.variant)}


def make_case(folder: Path, case: Case, seed: Sequence[int]) -> dict[str, Any]:
    """Write one campaign and return its label.

    A joint that runs away under its disturbances, or whose own parameters take them up, is drawn again; in the end it
    is one without gravity, which hides least.

    Parameters
    ----------
    folder
        Folder of the campaign; its name is that of the case.
    case
        What is hidden, and where.
    seed
        Numbers that fix all random draws; the third one chooses the last joint.

    Returns
    -------
    dict
        Label of the case.

    Raises
    ------
    NumericalError
        Where this happens to the last joint, too.
    """
    for attempt in range(1, DRAWS):
        try:
            return write_case(folder, case, seed, choose_inputs(case.joint, case.inputs))
        except NumericalError:
            seed = [*seed, attempt]
    last = replace(case, device="single_joint", joint=UPRIGHT[seed[2] % len(UPRIGHT)])
    return write_case(folder, last, seed, choose_inputs(last.joint, last.inputs))


def write_case(folder: Path, case: Case, seed: Sequence[int], runs: Sequence[Cosine]) -> dict[str, Any]:
    """Draw the joint and the sizes of a case once, and write its campaign.

    Parameters
    ----------
    folder
        Folder of the campaign; its name is that of the case.
    case
        What is hidden, and where.
    seed
        Numbers that fix all random draws.
    runs
        Torques of the runs.

    Returns
    -------
    dict
        Label of the case, as `make_cases` describes it.

    Raises
    ------
    NumericalError
        Where the joint runs away under its disturbances, or its own parameters take them up.
    InputError
        Where a disturbance is unknown.
    """
    rng = np.random.default_rng(list(seed))
    parameters, known = draw_joint(case.joint, case.device, rng)
    hidden: dict[str, Mapping[str, float]] = {}
    label: dict[str, Any] = {"case": folder.name, **asdict(case), "base": {name: parameters[name] for name in BASE}}
    if case.effects:
        base = reach(parameters, runs[:: len(runs) // 2], fixed_parameters(case.joint, known))
        label |= {"hidden": hidden, "left_over_noise": {}, "share_of_motion": {}}
        for name in case.effects:
            shape = Shape.draw(rng)
            if name == RANDOM:
                hidden[name] = _scatter(case, base, shape)
                continue
            hidden[name], left = _size(case, base, name, shape, rng)
            label["left_over_noise"][name] = left / Sensor(noise=case.noise).std
            label["share_of_motion"][name] = base.share(base.effect(hidden[name]))
    sensor = Sensor(noise=case.noise, coloured=case.coloured, correlation_time=case.correlation_time)
    make_joint_campaign(
        folder, case.joint, parameters, runs, effects=hidden, sensor=sensor, seed=int(rng.integers(2**31)),
        device=case.device, known=known, title=f"Synthetic blind case {folder.name}",
    )  # fmt: skip
    return label


def make_cases(  # noqa: PLR0913 - what a study sets, by keyword
    out: Path,
    n: int,
    seed: int,
    *,
    kinds: Sequence[str] = tuple(KINDS),
    sizes: Sequence[str] = SIZES,
    inputs: str = "mixed",
    effects: Sequence[str] = (),
    workers: int = 1,
) -> list[dict[str, Any]]:
    """Write the campaigns of a blind study below ``out/cases`` and their labels to ``out/labels.json``.

    Parameters
    ----------
    out
        Folder of the study.
    n
        Number of cases.
    seed
        Seed of all random draws.
    kinds
        Some of ``none``, ``single``, ``pair``, ``scatter``, ``scatter_with`` (an effect together with scatter) and
        ``unlisted`` (a disturbance outside the catalogue).
    sizes
        ``nominal`` (1 to 5 % of the motion, and at least twice the noise after a refit), ``threshold`` (a refit leaves
        0.1 to 0.3 of the noise), ``small`` (their geometric mean).
    inputs
        ``rich``, ``table3`` or ``mixed``.
    effects
        The only names that may be hidden; all where empty.
    workers
        Processes; the cases do not depend on it.

    Returns
    -------
    list of dict
        The labels: kind, hidden effects with parameters, size, joint, device, noise; ``left_over_noise`` is what a
        refit leaves of an effect over the noise, ``share_of_motion`` its RMS over that of the motion.

    Raises
    ------
    InputError
        Where a kind, a size, the inputs or an effect is unknown, or no case can hide the effects.
    NumericalError
        Where even the last joint that is drawn runs away under its disturbances, or takes them up.
    """
    cases = plan(n, np.random.default_rng([seed, 0]), kinds, sizes, inputs, effects)
    return write_cases(out, seed, cases, make_case, series=1, workers=workers)


@click.command(help=__doc__)
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), required=True, help="Folder to write.")
@click.option("--cases", "count", type=click.IntRange(min=1), default=40, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--truth", type=click.Choice(["own", "stranger"]), default="own", show_default=True)
@click.option("--kinds", default="", metavar="KIND,KIND", help=f"Some of {', '.join(KINDS)}; several for a stranger.")
@click.option("--sizes", default=",".join(SIZES), show_default=True, help="Not those of a stranger, which has a range.")
@click.option("--inputs", type=click.Choice(["rich", "table3", "mixed"]), default="mixed", show_default=True)
@click.option("--effects", default="", metavar="ID,ID", help="Hide no others than these.")
@click.option("--workers", type=click.IntRange(min=1), default=os.cpu_count() or 1, show_default="cores")
@click.option("--extra", default=None, metavar="CASE", help="Add a run to a copy of this case of the study in --out.")
@click.option("--to", type=click.Path(path_type=Path, file_okay=False), help="Folder of the copy.")
@click.option("--amplitude", type=float, default=0.0, help="Of the added run's torque [N m].")
@click.option("--frequency", type=float, default=0.0, help="Of the added run's torque [rad/s].")
@click.option("--end-frequency", type=float, default=None, help="Of the added run's torque, where it is swept [rad/s].")
@click.option("--offset", type=float, default=0.0, help="Of the added run's torque [N m].")
@click.option("--spacing", type=float, default=0.01, show_default=True, help="Of the added run's rows [s].")
@click.option("--repeats", type=click.IntRange(min=1), default=1, show_default=True, help="How often it is made.")
@click.option("--duration", type=float, default=16.0, show_default=True, help="Of the added run [s].")
@exit_codes
def main(out: Path, count: int, seed: int, *, truth: str, extra: str | None, to: Path | None, **choices: Any) -> None:
    """Write the cases, or one further run."""
    drawn = {name: choices.pop(name) for name in ("inputs", "workers")}
    drawn |= {name: [part for part in choices.pop(name).split(",") if part] for name in ("kinds", "sizes", "effects")}
    if extra is None:
        labels = _make(truth, out, count, seed, drawn)
        click.echo(f"{out / 'cases'}: {len(labels)} blind cases; answers in {out / 'labels.json'}")
    elif to is None:
        raise InputError("--extra", expected="--to FOLDER beside it", got="none")
    else:
        click.echo(f"{add_run(out, extra, choices, to)}: {extra} with one run more")


def _make(truth: str, out: Path, count: int, seed: int, drawn: dict[str, Any]) -> list[dict[str, Any]]:
    sizes = drawn.pop("sizes")
    if truth == "stranger":
        return make_stranger_cases(out, count, seed, **drawn)
    return make_cases(out, count, seed, sizes=sizes, **drawn | {"kinds": drawn["kinds"] or tuple(KINDS)})


if __name__ == "__main__":
    main()
