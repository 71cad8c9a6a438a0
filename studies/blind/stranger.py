"""A case of the stranger scored: a name is right if it is the kind of what is hidden.

The table of kinds, `studies.hidden.kinds`, and these rules were written down before any search saw a case:

1. Where nothing is hidden but a friction law that a refit of LuGre friction cannot follow, the right answer is that
   something outside the catalogue is missing, or that friction is of another kind: another law or, where the stranger's
   Stribeck curve is no Gaussian, a curve of another shape.
2. Beside an effect, such a law changes nothing of what is right: the kinds that are hidden have to be named, and no
   other but the kind of friction.
3. Where the law leaves next to nothing, the kind of friction is neither asked for nor wrong.
4. A verdict that names in part, and says that something smaller is left, is right where its names are those kinds: the
   formulas of the machine are not the catalogue's, and something is left. With other names it is as wrong as any.

The intervals of parameters are not scored, for the formulas differ.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from studies.blind.outcome import Outcome, score_case
from studies.hidden.kinds import KINDS, LAW, kinds_of

SHAPE = "stribeck_shape"
"""The name that stands for the stranger's friction beside `LAW`."""
WITHOUT_CURVE = "dahl"
"""The stranger's law that has no Stribeck curve, so that none of another shape is right."""


def score_stranger(
    label: Mapping[str, Any], found: Mapping[str, Any] | None, *, left_out: Sequence[str] = (), reason: str = ""
) -> Outcome:
    """Score one finding against the label of a case of the stranger.

    Parameters
    ----------
    label
        Label of the case, as `studies.hidden.stranger.make_stranger_cases` describes it.
    found
        Finding of the workflow, as its JSON holds it; None where the workflow failed.
    left_out
        Entries that the catalogue lacked.
    reason
        Why the workflow failed.

    Returns
    -------
    Outcome
        With the kinds in place of names, the first name of each.
    """
    return score_case(in_kinds(label), _found_in_kinds(found, label), left_out=left_out, reason=reason)


def in_kinds(label: Mapping[str, Any]) -> dict[str, Any]:
    """Return a label in the catalogue's names.

    Parameters
    ----------
    label
        Label of a case of the stranger.

    Returns
    -------
    dict
        Label for `score_case`: the first name of each kind, a kind of case that says whether the friction law shows,
        and no parameters to be covered.
    """
    effects, outside = label["effects"], label["outside"]
    kind = str(label["kind"])
    if outside:
        kind = f"{kind} beside another friction law" if effects else "unlisted"
    return {**label, "effects": kinds_of_label(label), "kind": kind, "hidden": {}}


def kinds_of_label(label: Mapping[str, Any]) -> list[str]:
    """Return the names that are right for a case.

    Parameters
    ----------
    label
        Label of a case of the stranger.

    Returns
    -------
    list of str
        The first name of each kind that is hidden; the friction law where nothing else is.
    """
    return [KINDS[name][0] for name in label["effects"]] or list(label["outside"])


def _found_in_kinds(found: Mapping[str, Any] | None, label: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return a finding in kinds; where the friction law is not asked for, its kind is passed over."""
    if found is None:
        return None
    hidden = label["effects"]
    of_friction = {LAW, SHAPE} if label["friction"]["law"] != WITHOUT_CURVE else {LAW}
    asked = not hidden and bool(label["outside"])

    def kind(id: str) -> str:
        return LAW if id in of_friction else kinds_of([id], hidden)[0]

    named = [{**e, "id": kind(e["id"])} for e in found["effects"]]
    effects = [e for e in named if asked or e["id"] != LAW]
    verdict = found["verdict"]
    if named and not effects and verdict in ("named", "partly_named", "ambiguous"):
        verdict = "nothing_missing"
    if verdict == "partly_named" and {e["id"] for e in effects} == set(kinds_of_label(label)):
        verdict = "named"
    sets = ({kind(id) for id in a["ids"]} for a in found["alternatives"])
    alternatives = [{"ids": sorted(ids if asked else ids - {LAW})} for ids in sets]
    return {**found, "verdict": verdict, "effects": effects, "alternatives": alternatives}
