"""One blind case scored: what was hidden against the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from studies.blind.truth import true_value

Result = Literal[
    "named", "among_alternatives", "nothing_rightly", "flagged", "named_in_part", "wrong_name", "wrong_alternatives",
    "missed", "unnamed", "false_alarm", "failed",
]  # fmt: skip
RIGHT: tuple[Result, ...] = ("named", "among_alternatives", "nothing_rightly", "flagged")
MEANING: dict[Result, str] = {
    "named": "every hidden effect named, no other",
    "among_alternatives": "ambiguous, the truth among the alternatives",
    "nothing_rightly": "nothing hidden, nothing found",
    "flagged": "outside the catalogue: unlisted or ambiguous",
    "named_in_part": "some of the hidden effects named, or others beside them",
    "wrong_name": "other effects named than those hidden",
    "wrong_alternatives": "ambiguous between effects that are not hidden",
    "missed": "something hidden, nothing found",
    "unnamed": "in the catalogue, but called unlisted",
    "false_alarm": "nothing hidden, something found",
    "failed": "no verdict",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Covered:
    """A parameter of a rightly named effect.

    Parameters
    ----------
    effect, parameter
        Ids of the effect and of its parameter.
    true, value, std
        Truth, estimate and its standard deviation, in the parameter's unit.
    inside
        Whether the interval holds the truth.
    """

    effect: str
    parameter: str
    true: float
    value: float
    std: float
    inside: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One case: its label in short, the verdict, and how that scores.

    Parameters
    ----------
    case, kind, size, joint, device, inputs
        As in `studies.hidden.plan.Case`.
    coloured
        Whether the noise is correlated.
    truth
        Names of the hidden effects.
    verdict
        Verdict of the search; ``failed`` without one.
    names
        Ids of the named effects.
    alternatives
        Sets of ids that an ambiguous verdict leaves open.
    result
        How the verdict scores; `MEANING` says it in words.
    left_out
        Entries that the catalogue lacked.
    proposed
        Whether the search proposes a run that tells the rivals apart.
    closed
        Share of the excess RMS that is removed on held-out runs [1], beside the scatter where amplitudes scatter; None
        where there is none.
    wall_s, simulations
        Duration [s] and simulated runs of the search; None where it failed.
    parameters
        Parameters of the rightly named effects.
    reason
        Why the workflow failed.
    """

    case: str
    kind: str
    size: str
    joint: int
    device: str
    inputs: str
    coloured: bool
    truth: tuple[str, ...]
    verdict: str
    names: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    result: Result
    left_out: tuple[str, ...] = ()
    proposed: bool = False
    closed: float | None = None
    wall_s: float | None = None
    simulations: int | None = None
    parameters: tuple[Covered, ...] = ()
    reason: str = ""

    @property
    def right(self) -> bool:
        """Whether the verdict is right."""
        return self.result in RIGHT

    @property
    def wrong_as_certain(self) -> bool:
        """Whether the verdict tells names as certain that are not exactly what is hidden."""
        return self.verdict == "named" and not self.right

    def as_json(self) -> dict[str, Any]:
        """Convert to an entry of the study's JSON.

        Returns
        -------
        dict
            The fields by name, those left out that are None or empty.
        """
        return {key: value for key, value in asdict(self).items() if value not in (None, (), "")}


def score_case(
    label: Mapping[str, Any], found: Mapping[str, Any] | None, *, left_out: Sequence[str] = (), reason: str = ""
) -> Outcome:
    """Score one finding against its label.

    Parameters
    ----------
    label
        Label of the case: what is hidden, and the parameters of the joint.
    found
        Finding of the workflow, as its JSON holds it; None where the workflow failed.
    left_out
        Entries that the catalogue lacked; a case that hides one of them is outside the catalogue.
    reason
        Why the workflow failed.

    Returns
    -------
    Outcome
    """
    truth = tuple(sorted(label["effects"]))
    names = tuple(sorted({e["id"] for e in found["effects"]})) if found else ()
    alternatives = _alternatives(names, found) if found else ()
    outside = label["kind"] == "unlisted" or bool(set(truth) & set(left_out))
    verdict = str(found["verdict"]) if found else "failed"
    result = _result(set(truth), verdict, set(names), alternatives, outside)
    gap = (found or {}).get("gap", {}).get("validate") or {}
    return Outcome(
        case=label["case"], kind=label["kind"], size=label["size"], joint=label["joint"], device=label["device"],
        inputs=label["inputs"], coloured=label["coloured"] > 0, truth=truth, verdict=verdict, names=names,
        alternatives=alternatives if verdict == "ambiguous" else (), result=result, left_out=tuple(left_out),
        proposed=bool(found and (found.get("next_experiment") or {}).get("tells")),
        closed=gap.get("closed_beside_scatter", gap.get("closed")),
        wall_s=found["wall_s"] if found else None, simulations=found["simulations"] if found else None,
        parameters=_parameters(label, found) if found and not outside else (), reason=reason,
    )  # fmt: skip


def _alternatives(names: tuple[str, ...], found: Mapping[str, Any]) -> tuple[tuple[str, ...], ...]:
    """Return the sets of names that an ambiguous verdict leaves open.

    A rival stands for one of the effects of the verdict, so each set is the named one with at most one name changed.
    """
    rivals = [tuple(sorted(a["ids"])) for a in found["alternatives"]]
    swapped = [tuple(sorted({*names} - {name} | {*ids})) for ids in rivals for name in names]
    return tuple(dict.fromkeys((names, *rivals, *swapped)))


def _result(
    truth: set[str], verdict: str, names: set[str], alternatives: tuple[tuple[str, ...], ...], outside: bool
) -> Result:
    if verdict == "failed":
        return "failed"
    if not truth:
        return "nothing_rightly" if verdict == "nothing_missing" else "false_alarm"
    if verdict in ("nothing_missing", "named"):
        return "missed" if verdict == "nothing_missing" else _judge_names(truth, names)
    if verdict == "partly_named":  # says that something more is missing, so that even the right names are not all right
        return "named_in_part" if names & truth else "wrong_name"
    if outside or verdict == "unlisted":
        return "flagged" if outside else "unnamed"
    return "among_alternatives" if any(truth == set(a) for a in alternatives) else "wrong_alternatives"


def _judge_names(truth: set[str], names: set[str]) -> Result:
    if names == truth:
        return "named"
    return "named_in_part" if names & truth else "wrong_name"


def _parameters(label: Mapping[str, Any], found: Mapping[str, Any]) -> tuple[Covered, ...]:
    """Hold the 95 % intervals of rightly named effects against the truth, where the label holds it.

    Behind a tendon the inertia that other effects act on is the link's alone.
    """
    checked = []
    everything = label.get("hidden", {})
    link = next((h["inertia"] for h in everything.values() if "inertia" in h), label["base"]["inertia"])
    for effect in found["effects"] if found["verdict"] in ("named", "ambiguous") else ():
        hidden = everything.get(effect["id"])
        for id, told in effect["parameters"].items() if hidden else ():
            true = true_value(id, hidden, label["base"] | {"inertia": link})
            if true is not None and told["std"]:
                low, high = told["interval"]
                inside = low <= true <= high
                covered = {"true": true, "value": told["value"], "std": told["std"], "inside": inside}
                checked.append(Covered(effect=effect["id"], parameter=id, **covered))
    return tuple(checked)
