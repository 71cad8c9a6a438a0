"""Which cases of the stranger to make: what is hidden, on which joint and device, with which inputs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from haptid.support.errors import InputError
from haptid.virtual_device.stranger.effects import FORMULAS
from haptid.virtual_device.stranger.ranges import read_ranges
from studies.hidden.kinds import KINDS


@dataclass(frozen=True, slots=True, kw_only=True)
class StrangerCase:
    """One case before its joint is drawn.

    Parameters
    ----------
    kind
        ``none``, ``single`` or ``several``.
    hides
        Names of `FORMULAS`.
    joint
        Number of the joint.
    device
        ``single_joint`` or ``freedom6s``.
    inputs
        ``rich`` or ``table3``.
    """

    kind: str
    hides: tuple[str, ...]
    joint: int
    device: str
    inputs: str


def plan_stranger(
    count: int,
    rng: np.random.Generator,
    *,
    kinds: Sequence[str] = (),
    inputs: str = "mixed",
    effects: Sequence[str] = (),
) -> list[StrangerCase]:
    """Draw cases; single effects go through all names in random order before one comes again.

    Parameters
    ----------
    count
        Number of cases.
    rng
        Random generator, which moves on.
    kinds
        Some of ``none``, ``single``, ``several``; all where empty.
    inputs
        Torques of the runs: ``rich``, ``table3`` or ``mixed``.
    effects
        Where not empty, no others are hidden.

    Returns
    -------
    list of StrangerCase
        In random order.

    Raises
    ------
    InputError
        Where a kind or an effect is unknown.
    """
    shares = read_ranges()["case"]["kinds"]
    for name, known, chosen in (("kinds", shares, kinds), ("effects", FORMULAS, effects)):
        if not set(chosen) <= set(known):
            raise InputError(where=f"--{name}", expected=f"some of {', '.join(known)}", got=", ".join(chosen))
    slots = [kind for kind in kinds or shares for _ in range(shares[kind])]
    order = rng.permutation(np.array([slots[k % len(slots)] for k in range(count)]))
    names = _endless(effects or tuple(FORMULAS), rng)
    return [_draw_case(str(kind), names, inputs, rng) for kind in order]


def _endless(names: Sequence[str], rng: np.random.Generator) -> itertools.chain[str]:
    rounds = (np.array(names)[rng.permutation(len(names))] for _ in itertools.count())
    return itertools.chain.from_iterable(map(str, order) for order in rounds)


def _draw_case(kind: str, names: itertools.chain[str], inputs: str, rng: np.random.Generator) -> StrangerCase:
    low, high = read_ranges()["case"]["several"]
    count = {"none": 0, "single": 1, "several": int(rng.integers(low, high + 1))}[kind]
    hides: list[str] = []
    for name in itertools.islice(names, 20 * count):  # a name that stands for a kind already hidden is passed over
        taken = {id for other in hides for id in KINDS[other]}
        if len(hides) < count and not taken & set(KINDS[name]):
            hides.append(name)
        if len(hides) == count:
            break
    return StrangerCase(
        kind=kind,
        hides=tuple(sorted(hides)),
        joint=int(rng.integers(6)),
        device="single_joint" if rng.random() < 0.6 else "freedom6s",
        inputs=inputs if inputs != "mixed" else str(rng.choice(["rich", "rich", "table3"])),
    )
