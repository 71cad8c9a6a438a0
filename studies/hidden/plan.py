"""Which blind cases to make: what is hidden, how large, on which device, with which inputs and noise."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from haptid.support.errors import InputError
from haptid.virtual_device.machine.effects import LISTED, UNLISTED

KINDS = {"none": 4, "single": 10, "pair": 2, "scatter": 1, "scatter_with": 2, "unlisted": 2}
"""Kinds of cases with the share that each takes of a mixed set."""
SIZES = ("nominal", "small", "threshold")
RANDOM = "amplitude_scatter"
NAMED = tuple(name for name in LISTED if name != RANDOM)
ONE_TENDON = {"tendon_elasticity", "tendon_slack"}
"""Two descriptions of the one tendon that a joint has: together they are the second alone."""
UPRIGHT = (0, 3)
"""Joints with a vertical axis: no gravity in their equation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One blind case.

    Parameters
    ----------
    kind
        One of `KINDS`.
    effects
        Names of the hidden effects.
    size
        One of `SIZES`; ``none`` where nothing is hidden.
    joint
        Number of the joint.
    device
        ``single_joint`` or ``freedom6s``.
    inputs
        ``rich`` or ``table3``.
    noise
        Standard deviation of the sensor noise [rad].
    coloured, correlation_time
        Standard deviation [rad] and time constant [s] of an added first-order autoregressive noise.
    scatter
        Relative scatter of the cycles' amplitude at nominal size [1].
    """

    kind: str
    effects: tuple[str, ...]
    size: str
    joint: int
    device: str
    inputs: str
    noise: float
    coloured: float
    correlation_time: float
    scatter: float


def plan(
    count: int,
    rng: np.random.Generator,
    kinds: Sequence[str],
    sizes: Sequence[str],
    inputs: str,
    effects: Sequence[str] = (),
) -> list[Case]:
    """Draw cases; every kind goes through its effects and sizes in random order before one comes again.

    Parameters
    ----------
    count
        Number of cases.
    rng
        Random generator, which moves on.
    kinds
        Names of `KINDS`, each with its share.
    sizes
        Names of `SIZES`.
    inputs
        Torques of the runs: ``rich``, ``table3`` or ``mixed``.
    effects
        Where not empty, no others are hidden (`RANDOM` always may be).

    Returns
    -------
    list of Case
        In random order.

    Raises
    ------
    InputError
        Where a kind, a size or an effect is unknown, no kind or size is given, or a kind can hide none of the
        effects.
    """
    for name, known, chosen in (("kinds", KINDS, kinds), ("sizes", SIZES, sizes)):
        if not set(chosen) <= set(known) or not chosen:
            raise InputError(where=f"--{name}", expected=f"some of {', '.join(known)}", got=", ".join(chosen) or "none")
    if unknown := set(effects) - {*LISTED, *UNLISTED}:
        raise InputError(where="--effects", expected="names of the catalogue", got=", ".join(sorted(unknown)))
    slots = [kind for kind in kinds for _ in range(KINDS[kind])]
    order = [slots[k % len(slots)] for k in range(count)]
    sources = {kind: _shuffle(_hidden(kind, sizes, effects), rng) for kind in kinds}
    return [_case(kind, *next(sources[kind]), inputs, rng) for kind in rng.permutation(np.array(order))]


def _hidden(kind: str, sizes: Sequence[str], effects: Sequence[str]) -> list[tuple[tuple[str, ...], str]]:
    """Return all names and sizes of one kind."""
    choices: list[tuple[tuple[str, ...], str]]
    if kind == "none":
        choices = [((), "none")]
    elif kind == "scatter":
        choices = [((RANDOM,), size) for size in sizes]
    elif kind == "pair":
        choices = [(names, "nominal") for names in itertools.combinations(NAMED, 2) if set(names) != ONE_TENDON]
    elif kind == "scatter_with":
        choices = [((name, RANDOM), "nominal") for name in NAMED]
    else:
        names = NAMED if kind == "single" else tuple(UNLISTED)
        choices = [((name,), size) for name in names for size in sizes]
    allowed = [c for c in choices if not effects or set(c[0]) <= {*effects, RANDOM}]
    if not allowed:
        raise InputError(where="--effects", expected=f"names that the kind {kind!r} hides", got=", ".join(effects))
    return allowed


def _shuffle(
    choices: list[tuple[tuple[str, ...], str]], rng: np.random.Generator
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Go through the choices without end, in a new order each round."""
    while True:
        for k in rng.permutation(len(choices)):
            yield choices[k]


def _case(kind: str, effects: tuple[str, ...], size: str, inputs: str, rng: np.random.Generator) -> Case:
    upright = "payload_gravity" in effects
    joint = int(rng.choice(UPRIGHT) if upright else rng.integers(6))
    coloured = kind == "none" and bool(rng.random() < 0.25)
    return Case(
        kind=kind,
        effects=effects,
        size=size,
        joint=joint,
        device="single_joint" if upright or rng.random() < 0.6 else "freedom6s",
        inputs=inputs if inputs != "mixed" else str(rng.choice(["rich", "rich", "table3"])),
        noise=float(rng.choice([1e-4, 2e-4, 2e-4, 4e-4])),
        coloured=float(rng.choice([1e-4, 2e-4])) if coloured else 0.0,
        correlation_time=float(np.round(rng.uniform(0.02, 0.1), 3)),
        scatter=float(np.round(rng.uniform(0.005, 0.03), 4)) if RANDOM in effects else 0.0,
    )
