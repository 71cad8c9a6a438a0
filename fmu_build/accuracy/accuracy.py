"""How good an exported model is: results in, `Accuracy` out, which goes into the FMU as files and as its page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from haptid.fmu_build.accuracy import stored_draws
from haptid.fmu_build.accuracy.stored_draws import Known
from haptid.fmu_build.accuracy.verification import joint_in_tests, joint_in_whole
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.exchange.discrepancy_json import Finding
from haptid.fmu_build.exchange.identification_json import Identified, words_of_campaign
from haptid.model.equations.equations import Equations

NOT_SEARCHED = "no search for missing effects went into this model"


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """Say how good the values of a model are, and how well they are known.

    Parameters
    ----------
    origin
        What the values come from, in a few words, as the description of the FMU says it.
    synthetic
        Whether a virtual device made the data; None where there are none.
    known
        Draws and summaries of the parameters, by ids or FMU variable names.
    joints
        Verification of each joint (`fmu_build.accuracy.verification`).
    effects
        Catalogue effects in the model, with estimates, evidence, stability and the gap that they close.
    searched
        Sentence about the search for missing effects.
    digests
        Campaign, data and code that the values come from.
    """

    origin: str
    synthetic: bool | None
    known: Known
    joints: tuple[Mapping[str, Any], ...] = ()
    effects: tuple[Mapping[str, Any], ...] = ()
    searched: str = NOT_SEARCHED
    digests: Mapping[str, Any] = field(default_factory=dict)


FIRST_GUESSES = Accuracy(
    origin="first guesses",
    synthetic=None,
    known=Known(draws=None, why="no parameter was identified: the values are first guesses"),
)
"""The accuracy of a model that nothing was measured of."""


def of_joint(data: Mapping[str, Any], joint: int, folder: Path | None) -> Accuracy:
    """Return the accuracy of one joint tested alone.

    Parameters
    ----------
    data
        Content of an ``identification.json`` with such a test.
    joint
        Number of the joint.
    folder
        Folder of the results, where draws and posterior lie; None where there is none.

    Returns
    -------
    Accuracy

    Raises
    ------
    InputError
        Where a file of draws is damaged.
    """
    tests = [c for c in data["configurations"] if list(c["free_joints"]) == [joint]][:1]
    return Accuracy(
        origin=f"identified from {words_of_campaign(data)}",
        synthetic=not data.get("measured", False),
        known=stored_draws.of_joint(data, joint, folder),
        joints=(joint_in_tests(tests, joint),),
        digests=_digests(data, tests),
    )


def of_device(data: Mapping[str, Any], name: str, folder: Path | None, findings: Sequence[Finding] = ()) -> Accuracy:
    """Return the accuracy of the whole device.

    Parameters
    ----------
    data
        Content of an ``identification.json``.
    name
        Name of the device.
    folder
        Folder of the results, where draws lie; None where there is none.
    findings
        Effects that the model includes.

    Returns
    -------
    Accuracy

    Raises
    ------
    InputError
        Where a file of draws is damaged.
    """
    tests, runs = data["configurations"], data.get("verification", {}).get("runs", [])
    numbers = sorted({joint for test in tests for joint in test["free_joints"]})
    joints = [joint_in_whole(joint_in_tests(tests, joint), runs, joint, after=bool(findings)) for joint in numbers]
    effects = tuple({"joint": f.joint, **entry} for f in findings for entry in f.named)
    return Accuracy(
        origin=f"identified from {words_of_campaign(data)}",
        synthetic=not data.get("measured", False) or any(f.synthetic for f in findings),
        known=stored_draws.of_device(data, name, folder),
        joints=tuple(joints),
        effects=effects,
        searched=_tell_searched_joints(findings),
        digests=_digests(data, tests),
    )


def _tell_searched_joints(findings: Sequence[Finding]) -> str:
    """Say which joints were searched, and what was named there that equations cannot hold, as a random effect."""
    if not findings:
        return NOT_SEARCHED
    joints = f"joints searched: {', '.join(str(f.joint) for f in findings)}"
    left = [f"{id} of joint {f.joint} ({reason})" for f in findings for id, reason in f.left]
    return f"{joints}; named there but not in the equations: {', '.join(left)}" if left else joints


def _digests(data: Mapping[str, Any], tests: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    keys = ("device", "campaign", "seed", "software")
    return {
        **{key: data[key] for key in keys if key in data},
        "inputs": data.get("inputs"),
        "code": data.get("code"),
        "data": {"-".join(map(str, test["free_joints"])): test.get("data") for test in tests},
    }


def without_replaced(accuracy: Accuracy, before: Identified, after: Identified, equations: Equations) -> Accuracy:
    """Leave out the draws of parameters whose values come from elsewhere than the draws.

    Parameters
    ----------
    accuracy
        Accuracy with the draws of the identification.
    before, after
        Values with their provenance as they were identified, and as the FMU starts with them: a parameter set or the
        refit with named effects may have replaced some.
    equations
        Equations of the FMU, whose orderings tie parameters to each other.

    Returns
    -------
    Accuracy
        A draw of Fc is left out beside a stated Fs, too: it might exceed Fs.
    """
    known = accuracy.known
    if known.draws is None:
        return accuracy
    replaced = {id for id, origin in after.provenance.items() if before.provenance.get(id) != origin}
    replaced |= {id for pair in equations.orderings if replaced & set(pair) for id in pair}
    if not replaced:
        return accuracy
    kept = known.draws.keep(set(known.draws.columns) - replaced - _names(equations, replaced))
    source = f"{kept.source}; without {len(replaced)} parameters whose values come from elsewhere"
    return replace(accuracy, known=replace(known, draws=replace(kept, source=source)))


def with_room_for_draws(equations: Equations, accuracy: Accuracy) -> Equations:
    """Widen the bounds of parameters to their draws, as an FMU refuses what lies outside.

    Parameters
    ----------
    equations
        Equations of the FMU.
    accuracy
        Draws that the FMU will carry.

    Returns
    -------
    Equations
        Bounds of a link's first guess may be closer than what its tests leave open.
    """
    drawn = accuracy.known.draws
    if drawn is None:
        return equations
    columns = dict(zip(drawn.columns, drawn.values.T, strict=True))
    changes: dict[str, dict[str, Any]] = {}
    for q in equations.parameters:
        own = columns.get(q.id, columns.get(structured_name(equations, q.id, q.structured)))
        if own is not None and own.size:
            changes[q.id] = {"lower": min(q.lower, float(own.min())), "upper": max(q.upper, float(own.max()))}
    return equations.with_parameters(changes)


def _names(equations: Equations, ids: set[str]) -> set[str]:
    return {structured_name(equations, q.id, q.structured) for q in equations.parameters if q.id in ids}
