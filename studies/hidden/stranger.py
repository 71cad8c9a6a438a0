"""Blind cases of the stranger: another machine hides other formulas, of which only the kind is in the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from haptid.support.errors import NumericalError
from haptid.virtual_device.machine.effects import Scales, Values
from haptid.virtual_device.machine.joint import BASE
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.stranger.campaign import make_stranger_campaign, positions, stranger_runs
from haptid.virtual_device.stranger.effects import FORMULAS, Formula, Shape
from haptid.virtual_device.stranger.physics import STRANGER
from haptid.virtual_device.stranger.ranges import draw_all, draw_friction, read_ranges
from haptid.virtual_device.stranger.readings import draw_recorder
from studies.hidden.joints import choose_inputs, draw_joint, fixed_parameters
from studies.hidden.kinds import LAW
from studies.hidden.sizing import reach
from studies.hidden.stranger_plan import StrangerCase, plan_stranger
from studies.hidden.stranger_sizing import STEP, Bench, Joint, draw_size
from studies.hidden.writing import write_cases

LAW_LEAVES = 0.1
"""What such a refit has to leave, over the noise, for the friction law to count as hidden."""
DRAWS = 8
"""How often a case is drawn before its joint may be said to run away."""
TWICE = 2.0
"""What a refit leaves of the least effect over the noise, from which on the size of a case is ``large``."""


def write_stranger_case(folder: Path, case: StrangerCase, seed: Sequence[int]) -> dict[str, Any]:
    """Draw the joint, the sizes and the recorder of a case, and write its campaign.

    Parameters
    ----------
    folder
        Folder of the campaign; its name is that of the case.
    case
        What is hidden, and where.
    seed
        Numbers that fix all random draws.

    Returns
    -------
    dict
        Label of the case, as `make_stranger_cases` describes it.

    Raises
    ------
    NumericalError
        Where the joint runs away under its disturbances, or its own parameters take them up.
    """
    rng = np.random.default_rng(list(seed))
    parameters, known = draw_joint(case.joint, case.device, rng)
    runs = choose_inputs(case.joint, case.inputs)
    recorder, stated = draw_recorder(rng)
    joint: Joint = {**parameters, **draw_friction(parameters, rng)}
    nearest = parameters | {"Fs": joint["Fs"]}  # LuGre friction of the same levels, from which a refit starts
    base = reach(nearest, runs[:: len(runs) // 2], fixed_parameters(case.joint, known), STEP)
    bench = Bench(base=base, joint=joint, still=positions(joint, base.runs, STEP), std=recorder.std)
    law = base.left(bench.still - base.motion) / recorder.std
    hidden, shapes = {}, {}
    for name in case.hides:
        shapes[name] = draw_all(read_ranges()["effects"][name], rng)
        effect = partial(_values, FORMULAS[name], _scales(parameters, base.runs, joint), shapes[name])
        largest = read_ranges()["case"]["largest_share"] / len(case.hides)
        hidden[name] = effect(draw_size(bench, effect, largest, rng))
    everything = {**joint, **{key: value for values in hidden.values() for key, value in values.items()}}
    tables = stranger_runs(case.joint, everything, runs, recorder, seed=int(rng.integers(2**31)))
    noise = {} if stated is None else {"noise_rad": float(f"{stated:.4g}")}
    make_stranger_campaign(folder, case.joint, tables, device=case.device, known=known, noise=noise)
    left = {name: bench.left(values) for name, values in hidden.items()}
    return {
        "case": folder.name, "truth": "stranger", "effects": list(case.hides), "kind": case.kind,
        "joint": case.joint, "device": case.device, "inputs": case.inputs,
        "size": _word(left), "base": {name: parameters[name] for name in BASE}, "friction": joint,
        "friction_law_left_over_noise": law, "outside": [LAW] if law >= LAW_LEAVES else [],
        "hidden": hidden, "shapes": shapes, "left_over_noise": left,
        "share_of_motion": {name: bench.share(values) for name, values in hidden.items()},
        "recorder": asdict(recorder), "stated": stated, "noise": recorder.white, "coloured": recorder.coloured,
        "correlation_time": recorder.correlation_time,
    }  # fmt: skip


def _values(formula: Formula, scales: Scales, shape: Shape, size: float) -> Values:
    return formula(scales, size, shape)


def _scales(parameters: dict[str, float], runs: Sequence[Cosine], joint: Joint) -> Scales:
    torque, frequency = max(run.amplitude for run in runs), float(np.median([run.frequency for run in runs]))
    return Scales.of(parameters, torque, frequency, STRANGER.rest_position({**joint, "law": 0.0}))


def _word(left: dict[str, float]) -> str:
    if not left:
        return "none"
    return "large" if min(left.values()) >= TWICE else "small"


def make_stranger_case(folder: Path, case: StrangerCase, seed: Sequence[int]) -> dict[str, Any]:
    """Write a case, drawn again where its joint runs away or takes up what should be hidden.

    Parameters
    ----------
    folder
        Folder of the campaign; its name is that of the case.
    case
        What is hidden, and where.
    seed
        Numbers that fix all random draws.

    Returns
    -------
    dict
        Label of the case; ``draws`` is how often it was drawn.

    Raises
    ------
    NumericalError
        Where no draw can hide what the case asks for.
    """
    for attempt in range(1, DRAWS):
        try:
            return write_stranger_case(folder, case, [*seed, attempt]) | {"draws": attempt}
        except NumericalError:
            continue
    return write_stranger_case(folder, case, [*seed, DRAWS]) | {"draws": DRAWS}


def make_stranger_cases(
    out: Path,
    n: int,
    seed: int,
    *,
    kinds: Sequence[str] = (),
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
        Some of ``none``, ``single`` and ``several``; all where empty.
    inputs
        ``rich``, ``table3`` or ``mixed``.
    effects
        The only names that may be hidden; all where empty.
    workers
        Processes; the cases do not depend on it.

    Returns
    -------
    list of dict
        The labels: what is hidden with its parameters, shape, what a refit leaves of it over the noise to first order
        and its share of the motion; the joint, its friction law and what a refit of LuGre friction leaves of that;
        ``outside`` names what the catalogue cannot express; the recorder, and what the campaign states of the noise.

    Raises
    ------
    InputError
        Where a kind or an effect is unknown.
    NumericalError
        Where no draw can hide what a case asks for.
    """
    cases = plan_stranger(n, np.random.default_rng([seed, 0]), kinds=kinds, inputs=inputs, effects=effects)
    return write_cases(out, seed, cases, make_stranger_case, series=2, workers=workers)
