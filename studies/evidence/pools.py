"""Pools of blind studies: every study of the ledger that is of a kind, by one rule, never a choice of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from haptid.support.errors import InputError
from haptid.support.files.files import read_json
from studies.blind.outcome import Covered, Outcome, Result
from studies.blind.score import Row, rate, share_of
from studies.ledger.entries import LEDGER, Entry, read_ledger

RULE = (
    "A pool takes every study of its kind that stands in the ledger, whatever its date, version and result. A study "
    "that was interrupted counts with the cases that it worked through; a case without a verdict is not right; a case "
    "that two versions worked through counts twice; a verdict counts as it was scored when its study ended, whatever "
    "was found out about it since. Studies that are lost have no cases to count, and are listed. Intervals are "
    "Wilson's, 95 %, and take the cases for independent."
)
KINDS: dict[str, str] = {
    "mixed": "all kinds mixed, or several",
    "single": "one effect of the catalogue",
    "pairs": "two effects, or one beside a scatter of the amplitude",
    "clean": "nothing, or scatter alone",
    "settled": "chosen effects, and the run that would tell rivals apart",
    "left_out": "one effect, and the catalogue without its entry",
}
"""Kinds of studies, by what they ask for, with what they hide."""
VERDICTS: dict[str, tuple[Result, ...]] = {
    "named exactly, or nothing rightly": ("named", "nothing_rightly"),
    "ambiguous, the truth among the alternatives": ("among_alternatives",),
    "outside the catalogue, and called unlisted or ambiguous": ("flagged",),
    "wrong: other names, some of the names, or wrong alternatives": (
        "named_in_part",
        "wrong_name",
        "wrong_alternatives",
    ),
    "called unlisted, though in the catalogue": ("unnamed",),
    "missed: something hidden, nothing found": ("missed",),
    "false alarm: nothing hidden, something found": ("false_alarm",),
    "no verdict: not finished in time, or an error": ("failed",),
}
"""What can become of a case; the first three count as right. Every result of a case is in one of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A study of the ledger.

    Parameters
    ----------
    entry
        Its entry.
    stored
        Content of its JSON; None where there is none.
    cases, left_out, settled
        Outcomes with the whole catalogue, without the true effect, and with the proposed run.
    """

    entry: Entry
    stored: Mapping[str, Any] | None
    cases: tuple[Outcome, ...]
    left_out: tuple[Outcome, ...]
    settled: tuple[Outcome, ...]

    @property
    def kind(self) -> str:
        """One of `KINDS`."""
        return kind_of(self.entry["plan"])


def read_studies(ledger: Path = LEDGER) -> tuple[Study, ...]:
    """Read all studies of a ledger.

    Parameters
    ----------
    ledger
        The ledger; results lie beside it.

    Returns
    -------
    tuple of Study
        In the order of the ledger, those without results among them.

    Raises
    ------
    InputError
        Where a file of results is missing or cannot be read.
    """
    return tuple(_read_study(entry, ledger.parent) for entry in read_ledger(ledger))


def _read_study(entry: Entry, folder: Path) -> Study:
    if "file" not in entry:
        return Study(entry=entry, stored=None, cases=(), left_out=(), settled=())
    path = folder / entry["file"]
    stored = read_json(path, "the blind.json of a study", ("studies.blind", "blind.schema.json"))
    try:
        passes = [
            tuple(outcome_of(case) for case in stored[name])
            for name in ("cases", "leave_one_out_cases", "settled_cases")
        ]
    except (KeyError, TypeError) as error:
        raise InputError(str(path), expected="cases as a study writes them", got=f"{error}") from None
    cases, left_out, settled = passes
    return Study(entry=entry, stored=stored, cases=cases, left_out=left_out, settled=settled)


def outcome_of(case: Mapping[str, Any]) -> Outcome:
    """Return a scored case from the entry of a study's JSON.

    Parameters
    ----------
    case
        As `Outcome.as_json` writes it.

    Returns
    -------
    Outcome
    """
    lists = {key: tuple(case.get(key, ())) for key in ("truth", "names", "left_out")}
    alternatives = tuple(tuple(names) for names in case.get("alternatives", ()))
    parameters = tuple(Covered(**each) for each in case.get("parameters", ()))
    return Outcome(**{**case, **lists, "alternatives": alternatives, "parameters": parameters})


def kind_of(plan: Mapping[str, Any]) -> str:
    """Return the kind of a study by its plan alone.

    Parameters
    ----------
    plan
        Plan of an entry.

    Returns
    -------
    str
        One of `KINDS`.

    Examples
    --------
    >>> kind_of({"passes": ["found"], "kinds": "none,scatter", "effects": ""})
    'clean'
    """
    hidden = {kind for kind in plan["kinds"].split(",") if kind}
    if plan["passes"] == ["without"]:
        return "left_out"
    if hidden == {"single"}:
        return "settled" if plan["effects"] and "settled" in plan["passes"] else "single"
    if hidden and hidden <= {"pair", "scatter_with"}:
        return "pairs"
    return "clean" if hidden and hidden <= {"none", "scatter"} else "mixed"


def verdict_rates(cases: Sequence[Outcome]) -> list[tuple[str, Row]]:
    """Return how often each of `VERDICTS` came, in their order, after the rate of right ones.

    Parameters
    ----------
    cases
        Outcomes with the whole catalogue.

    Returns
    -------
    list of (str, dict)
        What is counted, and its rate as `rate` returns it.
    """
    rows = [("right verdicts", share_of(cases, lambda o: o.right))]
    for words, results in VERDICTS.items():
        rows.append((words, rate(sum(o.result in results for o in cases), len(cases))))
    return rows


def named_rates(cases: Sequence[Outcome]) -> list[tuple[str, Row]]:
    """Return how often names are right where the catalogue has what is hidden, and how often what is told is so.

    Parameters
    ----------
    cases
        Outcomes with the whole catalogue.

    Returns
    -------
    list of (str, dict)
        What is counted, and its rate.
    """
    listed = [o for o in cases if o.truth and o.kind != "unlisted"]
    told = [o for o in cases if o.verdict == "named"]
    clean = [o for o in cases if not o.truth]
    correlated = [o for o in clean if o.coloured]
    outside = [o for o in cases if o.kind == "unlisted"]
    scatter = [o for o in cases if o.kind == "scatter"]
    return [
        ("effects of the catalogue hidden: named exactly", share_of(listed, _is("named"))),
        ("effects of the catalogue hidden: ambiguous, the truth among", share_of(listed, _is("among_alternatives"))),
        ("told as named: exactly what was hidden", share_of(told, _is("named"))),
        ("nothing hidden: something found", share_of(clean, _is("false_alarm"))),
        ("nothing hidden, correlated noise: something found", share_of(correlated, _is("false_alarm"))),
        ("scatter alone hidden: not right", share_of(scatter, lambda o: not o.right)),
        ("outside the catalogue: unlisted or ambiguous", share_of(outside, _is("flagged"))),
        ("outside the catalogue: a wrong name given as certain", share_of(outside, lambda o: o.wrong_as_certain)),
    ]


def left_out_rates(cases: Sequence[Outcome]) -> list[tuple[str, Row]]:
    """Return what became of cases whose true effect the catalogue lacked.

    Parameters
    ----------
    cases
        Outcomes without the true entry.

    Returns
    -------
    list of (str, dict)
        What is counted, and its rate.
    """
    return [
        ("true entry left out: unlisted or ambiguous", share_of(cases, _is("flagged"))),
        ("true entry left out: a wrong name given as certain", share_of(cases, lambda o: o.verdict == "named")),
        ("true entry left out: nothing found", share_of(cases, _is("missed"))),
        ("true entry left out: no verdict", share_of(cases, _is("failed"))),
    ]


def settled_rates(cases: Sequence[Outcome]) -> list[tuple[str, Row]]:
    """Return what the proposed runs told.

    Parameters
    ----------
    cases
        Outcomes with the proposed run.

    Returns
    -------
    list of (str, dict)
        What is counted, and its rate.
    """
    wrong = ("wrong_name", "named_in_part")
    return [
        ("proposed run made: named exactly", share_of(cases, _is("named"))),
        ("proposed run made: named wrongly", share_of(cases, lambda o: o.result in wrong)),
        ("proposed run made: no verdict", share_of(cases, _is("failed"))),
    ]


def coverage_rates(cases: Sequence[Outcome]) -> list[tuple[str, Row]]:
    """Return how often 95 % intervals hold the truth, and how often an estimate is beyond three standard errors.

    Parameters
    ----------
    cases
        Outcomes with the whole catalogue.

    Returns
    -------
    list of (str, dict)
        What is counted, and its rate; parameters of one case depend on each other.
    """
    checked = [p for o in cases for p in o.parameters]
    inside = sum(p.inside for p in checked)
    far = sum(abs(p.value - p.true) > 3.0 * p.std for p in checked)
    return [
        ("95 % intervals of named effects' parameters that hold the truth", rate(inside, len(checked))),
        ("estimates more than three standard errors off", rate(far, len(checked))),
    ]


def _is(result: Result) -> Callable[[Outcome], bool]:
    return lambda outcome: outcome.result == result
