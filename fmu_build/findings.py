"""Effects that a search named, from ``discrepancy/joint<j>.json`` into the equations of the whole device."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fmu_build.provenance import Provenance
from model.effect import Effect
from model.effects import named
from model.joint_parts import INERTIAL, Effects, of_the_test_alone
from model.quantity import Quantity
from support.errors import InputError

SCHEMA = "discrepancy/1"
VERDICTS = ("named", "ambiguous", "nothing_missing")
"""Verdicts that leave a model to take along."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What a search has left of one joint for a device whose joints move together.

    Parameters
    ----------
    joint
        Its number.
    effects
        Effects that go into the equations, parameters at the values of the refit.
    values, provenance
        Values by id of the whole device's parameters (``Ks_3``, ``cogging_sin_3``), and where they come from.
    left
        Effects that stay behind, with the reason.
    inertia
        Inertia of the joint in the refit.
    """

    joint: int
    effects: tuple[Effect, ...]
    values: dict[str, float]
    provenance: dict[str, Provenance | str]
    left: tuple[tuple[str, str], ...]
    inertia: float = math.nan


def finding_of(data: Mapping[str, Any], where: str, entries: dict[str, Effect]) -> Finding:
    """Return the finding that a ``discrepancy/joint<j>.json`` holds.

    Raises
    ------
    InputError
        For any other file, one without a name for what is missing, and an effect that ``entries`` do not have.
    """
    if data.get("schema") != SCHEMA or "joint" not in data:
        raise InputError(
            where, expected=f"a discrepancy/joint<j>.json of schema {SCHEMA}", got=repr(data.get("schema"))
        )
    if data["verdict"] not in VERDICTS:
        raise InputError(where, expected=f"one of the verdicts {', '.join(VERDICTS)}", got=data["verdict"])
    joint = int(data["joint"])
    keys = [":".join(filter(None, (e["id"], e.get("variant")))) for e in data["effects"]]
    found = named(keys, entries)
    taken = tuple(e for e in found if not of_the_test_alone(e))
    refit = {id: float(value) for id, value in (data.get("refit") or {}).items()}
    own = {q.id for e in taken for q in e.parameters}
    kept = {id: value for id, value in refit.items() if _belongs(id, own, found)}
    if any(_needs_inertia(e) for e in taken):
        kept["inertia"] = refit["inertia"]
    kind = "measured" if data.get("measured") else "SYNTHETIC"
    source = f"test of joint {joint} with {', '.join(keys)} ({kind} data)"
    std = {id: p.get("std") for e in data["effects"] for id, p in e["parameters"].items()}
    return Finding(
        joint=joint,
        effects=tuple(at_values(e, refit) for e in taken),
        values={f"{id}_{joint}": value for id, value in kept.items()},
        provenance={f"{id}_{joint}": Provenance(source=source, std=std.get(id), status="") for id in kept},
        left=tuple((e.id, reason) for e in found if (reason := of_the_test_alone(e))),
        inertia=refit.get("inertia", math.nan),
    )


def by_joint(findings: Sequence[Finding]) -> Effects:
    """Return the effects by joint.

    Raises
    ------
    InputError
        Where two findings are of the same joint.
    """
    joints = [f.joint for f in findings]
    if len(set(joints)) < len(joints):
        raise InputError("--with", expected="one finding per joint", got=f"joints {', '.join(map(str, joints))}")
    return {f.joint: f.effects for f in findings if f.effects}


def at_values(effect: Effect, values: Mapping[str, float]) -> Effect:
    """Return the effect with its parameters in SI units at ``values``.

    Bounds that are multiples of a scale are left off without it; zero is a bound at any scale.
    """
    scaled = {*effect.relative, *effect.origin}

    def quantity(q: Quantity) -> Quantity:
        value = values.get(q.id, q.initial)
        lower, upper = q.lower, q.upper
        if q.id in scaled:
            least = 0.0 if q.lower >= 0 and q.id not in effect.origin else -math.inf
            lower, upper = (value if q.scale == "log" else least), math.inf
        return q.but(initial=value, lower=min(lower, value), upper=max(upper, value))

    return effect.but(parameters=tuple(map(quantity, effect.parameters)), relative={}, origin={}, contenders=())


def _belongs(id: str, own: set[str], found: Sequence[Effect]) -> bool:
    """Whether a parameter of the joint's test is one of the whole device: neither inertial nor of what stays behind."""
    others = {q.id for e in found for q in e.parameters} - own
    return id not in INERTIAL and id not in others


def _needs_inertia(effect: Effect) -> bool:
    return effect.acceleration is not None or effect.inertia_factor is not None
