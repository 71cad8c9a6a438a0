"""Catalogue effects that a search named, for the whole device: ``discrepancy/joint<j>.json`` in, `Finding` out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from haptid.fmu_build.description.provenance import Provenance
from haptid.fmu_build.exchange.discrepancy_check import check_estimates, check_refit
from haptid.fmu_build.exchange.identification_json import Identified
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import find_effects
from haptid.model.equations.quantity import Quantity
from haptid.model.friction.registry import MISSING
from haptid.model.joint.joint_in_device import Effects, of_the_test_alone
from haptid.support.errors import InputError
from haptid.support.files.files import read_json

VERDICTS = ("named", "partly_named", "ambiguous", "nothing_missing")
"""Verdicts with a model that the whole device can include."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Hold the effects and the refit of one joint, for a device whose joints move together.

    Parameters
    ----------
    joint
        Number of the joint.
    source
        The file, as errors name it.
    effects
        Effects that go into the equations, parameters at the values of the refit.
    values, provenance
        All parameters of the refit by their ids in the whole device (``Ks_3``, ``cogging_sin_3``), and where they come
        from; the device has no use for some (``gravity_cos_3``).
    left
        Ids of the effects that the whole device does not include, each with the reason.
    named
        What the file says of each effect that goes into the equations, with the gap that all of them close.
    synthetic
        Whether a virtual device made the runs of the test.
    """

    joint: int
    source: str
    effects: tuple[Effect, ...]
    values: dict[str, float]
    provenance: dict[str, Provenance | str]
    left: tuple[tuple[str, str], ...]
    named: tuple[Mapping[str, Any], ...] = ()
    synthetic: bool = False


def read_finding(path: Path, catalogue: dict[str, Effect]) -> Finding:
    """Read the finding that a ``discrepancy/joint<j>.json`` holds.

    Parameters
    ----------
    path
        File that a search wrote.
    catalogue
        Catalogue effects by key.

    Returns
    -------
    Finding
        With the parameters of the effects at the values of the refit.

    Raises
    ------
    InputError
        For a file that does not follow the schema, a verdict outside `VERDICTS`, an effect that occurs twice or that
        the catalogue lacks, and impossible values.
    """
    return finding_of(read_discrepancy(path), str(path), catalogue)


def read_discrepancy(path: Path) -> dict[str, Any]:
    """Read a ``discrepancy/joint<j>.json`` with any verdict.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    dict
        Its content.

    Raises
    ------
    InputError
        Where the file cannot be read, is no JSON, or does not follow ``discrepancy.schema.json``.
    """
    return read_json(path, "a discrepancy/joint<j>.json", ("haptid.fmu_build.exchange", "discrepancy.schema.json"))


def law_of(data: Mapping[str, Any]) -> str | None:
    """Return the friction law that a finding names in the place of the one that was asked for.

    Parameters
    ----------
    data
        Content, as `read_discrepancy` returns it.

    Returns
    -------
    str or None
        Id of the law; None where the law stayed.
    """
    return next((str(e["variant"]) for e in data["effects"] if e["id"] == MISSING), None)


def finding_of(data: Mapping[str, Any], where: str, catalogue: dict[str, Effect]) -> Finding:
    """Take the finding from the content of a ``discrepancy/joint<j>.json``.

    Parameters
    ----------
    data
        Content, as `read_discrepancy` returns it.
    where
        Name of the file, for errors.
    catalogue
        Catalogue effects by key.

    Returns
    -------
    Finding
        See `read_finding`.

    Raises
    ------
    InputError
        For a verdict outside `VERDICTS`, another friction law, an effect that occurs twice or that the catalogue lacks,
        and impossible values.
    """
    if data["verdict"] not in VERDICTS:
        at, expected = f"{where}: verdict", f"one of the verdicts {', '.join(VERDICTS)}"
        raise InputError(at, expected=expected, got=repr(data["verdict"]))
    joint = data["joint"]
    if (law := law_of(data)) is not None:
        at = f"{where}: effects"
        todo = f'write friction = "{law}" into [joint.{joint}] of campaign.toml, and identify again'
        raise InputError(at, expected="effects beside the friction law that was asked for", got=law, todo=todo)
    keys = [":".join(filter(None, (e["id"], e.get("variant")))) for e in data["effects"]]
    found = _find_effects(keys, where, catalogue)
    taken = tuple(e for e in found if not of_the_test_alone(e))
    refit = {id: float(value) for id, value in (data.get("refit") or {}).items()}
    check_refit(refit, found, f"{where}: refit")
    for number, (effect, entry) in enumerate(zip(found, data["effects"], strict=True)):
        check_estimates(entry["parameters"], effect, f"{where}: effects[{number}].parameters")
    kind = "measured" if data.get("measured") else "SYNTHETIC"
    source = f"test of joint {joint} with {', '.join(keys)} ({kind} data)"
    std = {id: p.get("std") for e in data["effects"] for id, p in e["parameters"].items()}
    return Finding(
        joint=joint,
        source=where,
        effects=tuple(at_values(e, refit) for e in taken),
        values={f"{id}_{joint}": value for id, value in refit.items()},
        provenance={f"{id}_{joint}": Provenance(source=source, std=std.get(id), status="") for id in refit},
        left=tuple((e.id, reason) for e in found if (reason := of_the_test_alone(e))),
        named=tuple(
            {**entry, "gap": data.get("gap")}
            for effect, entry in zip(found, data["effects"], strict=True)
            if not of_the_test_alone(effect)
        ),
        synthetic=not data.get("measured"),
    )


def _find_effects(keys: Sequence[str], where: str, catalogue: dict[str, Effect]) -> tuple[Effect, ...]:
    known = {name for key, e in catalogue.items() for name in (key, e.id)}
    for key in keys:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            todo = f"is {near[0]!r} meant?" if near else "--effects names the folder of effects of your own"
            at = f"{where}: effects"
            raise InputError(at, expected="ids of the catalogue", got=repr(key), todo=todo)
    found = find_effects(keys, catalogue)
    ids = [e.id for e in found]
    for id in ids:
        if ids.count(id) > 1:
            at, got = f"{where}: effects", f"{id} {ids.count(id)} times"
            raise InputError(at, expected="every effect once", got=got)
    return found


def by_joint(findings: Sequence[Finding]) -> Effects:
    """Return the effects that findings bring into the whole device.

    Parameters
    ----------
    findings
        At most one per joint.

    Returns
    -------
    dict
        Effects by joint; joints without effects are left out.

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
    """Return an effect with its parameters at given values.

    Parameters
    ----------
    effect
        Catalogue effect. Parameters in ``effect.relative`` and ``effect.origin`` have bounds that are multiples of a
        scale of the test.
    values
        Value by id of the parameter, SI units; the first guess where absent.

    Returns
    -------
    Effect
        With absolute parameters. Bounds that depend on a scale become infinite, as the scale is unknown here, except
        a lower bound of 0, which holds at any scale. All bounds include the value.
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


def apply_refits(identified: Identified, findings: Sequence[Finding]) -> Identified:
    """Replace identified values by those of refits.

    Parameters
    ----------
    identified
        Values and provenance of the whole device.
    findings
        Their refits overrule ``identified``; a later finding overrules an earlier one.

    Returns
    -------
    Identified
        It may hold ids that the whole device does not have; `Identified.among` removes them.
    """
    values, provenance = identified.values, identified.provenance
    for finding in findings:
        values, provenance = values | finding.values, provenance | finding.provenance
    return Identified(values=values, provenance=provenance)
