"""Many scored cases in figures: rates with Wilson intervals, the confusion matrix, coverage, cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from studies.blind.outcome import Outcome, Result

Row = dict[str, Any]
NOTHING, SEVERAL = "nothing", "several"


def rate(hits: int, n: int) -> Row:
    """Return hits, n, their share and its 95 % interval (Wilson 1927).

    Parameters
    ----------
    hits
        Number of cases that count.
    n
        Number of cases.

    Returns
    -------
    dict
        ``hits``, ``n``, ``share``, ``low``, ``high``; the last three are None where n is 0.

    Examples
    --------
    >>> rate(9, 10)["low"] < 0.9 < rate(9, 10)["high"]
    True
    """
    if n == 0:
        return {"hits": 0, "n": 0, "share": None, "low": None, "high": None}
    interval = binomtest(hits, n).proportion_ci(0.95, "wilson")
    return {"hits": hits, "n": n, "share": hits / n, "low": float(interval.low), "high": float(interval.high)}


def share_of(outcomes: Sequence[Outcome], test: Callable[[Outcome], bool]) -> Row:
    """Return the `rate` at which outcomes pass a test.

    Parameters
    ----------
    outcomes
        Scored cases.
    test
        Whether an outcome counts.

    Returns
    -------
    dict
        As `rate` returns it.
    """
    return rate(sum(map(test, outcomes)), len(outcomes))


def confusion(outcomes: Iterable[Outcome]) -> dict[str, dict[str, int]]:
    """Count verdicts by what was hidden: rows are truths, columns names or verdicts.

    Parameters
    ----------
    outcomes
        Scored cases.

    Returns
    -------
    dict
        Number of cases by truth, then by name or verdict, both in alphabetical order.
    """
    counts: dict[str, Counter[str]] = {}
    for o in outcomes:
        counts.setdefault(_truth(o), Counter())[_classify(o)] += 1
    return {row: dict(sorted(counts[row].items())) for row in sorted(counts)}


def _truth(o: Outcome) -> str:
    if not o.truth:
        return NOTHING
    if len(o.truth) > 1:
        return f"{SEVERAL}: {o.kind}"
    return f"outside: {o.truth[0]}" if o.kind == "unlisted" else o.truth[0]


def _classify(o: Outcome) -> str:
    """One word for a verdict; sets of several names count as right, in part or wrong."""
    if o.verdict == "nothing_missing":
        return NOTHING
    if o.verdict != "named":
        return o.verdict if o.result != "among_alternatives" else "ambiguous, truth among"
    if len(o.truth) < 2 and len(o.names) == 1:
        return o.names[0]
    told: dict[Result, str] = {"named": f"{SEVERAL}, exact", "named_in_part": f"{SEVERAL}, in part"}
    return told.get(o.result, f"{SEVERAL}, wrong")


def by_kind_and_size(outcomes: Sequence[Outcome]) -> list[Row]:
    """Return the rates of right verdicts, and of effects named exactly, for every kind and size.

    Parameters
    ----------
    outcomes
        Scored cases.

    Returns
    -------
    list of dict
        ``kind``, ``size``, and ``right`` and ``exact`` as `rate` returns them.
    """
    rows = []
    for kind, size in sorted({(o.kind, o.size) for o in outcomes}):
        group = [o for o in outcomes if (o.kind, o.size) == (kind, size)]
        exact = share_of(group, lambda o: o.result in ("named", "nothing_rightly"))
        rows.append({"kind": kind, "size": size, "right": share_of(group, lambda o: o.right), "exact": exact})
    return rows


def false_alarms(outcomes: Sequence[Outcome]) -> Row:
    """Return the rates at which something was found where nothing was hidden, and at which more was found than scatter.

    Parameters
    ----------
    outcomes
        Scored cases of all kinds.

    Returns
    -------
    dict
        Rates over the cases that hide nothing (``all``, ``white_noise``, ``correlated_noise``), and
        ``beside_scatter`` over the cases that hide scatter alone: unlisted, or a name that is not hidden.
    """
    clean = [o for o in outcomes if o.kind == "none"]
    scatter = [o for o in outcomes if o.kind == "scatter"]

    def alarm(o: Outcome) -> bool:
        return o.result == "false_alarm"

    def beside(o: Outcome) -> bool:
        return o.verdict == "unlisted" or bool(set(o.names) - set(o.truth))

    return {
        "all": share_of(clean, alarm),
        "white_noise": share_of([o for o in clean if not o.coloured], alarm),
        "correlated_noise": share_of([o for o in clean if o.coloured], alarm),
        "beside_scatter": share_of(scatter, beside),
    }


def outside(outcomes: Sequence[Outcome]) -> Row:
    """Return the rates of cases that were flagged as outside the catalogue, named confidently, or not found.

    Parameters
    ----------
    outcomes
        Scored cases whose truth the catalogue lacks.

    Returns
    -------
    dict
        ``flagged``, ``confident_wrong_name`` and ``missed``, as `rate` returns them.
    """
    return {
        "flagged": share_of(outcomes, lambda o: o.result == "flagged"),
        "confident_wrong_name": share_of(outcomes, lambda o: o.wrong_as_certain),
        "missed": share_of(outcomes, lambda o: o.result == "missed"),
    }


def summarise_spread(values: Iterable[float | None]) -> Row:
    """Return the number, median, ninth decile and maximum of what is there.

    Parameters
    ----------
    values
        Numbers of one unit; None where there is none.

    Returns
    -------
    dict
        ``n``, ``median``, ``p90`` and ``max`` in that unit; the last three are None where n is 0.
    """
    known = np.array([v for v in values if v is not None], dtype=float)
    if known.size == 0:
        return {"n": 0, "median": None, "p90": None, "max": None}
    p90 = float(np.quantile(known, 0.9))
    return {"n": int(known.size), "median": float(np.median(known)), "p90": p90, "max": float(known.max())}


def coverage(outcomes: Sequence[Outcome]) -> Row:
    """Return the share of 95 % intervals of the effects' own parameters that hold the truth.

    Parameters
    ----------
    outcomes
        Scored cases.

    Returns
    -------
    dict
        Rate over ``all`` parameters, and ``parameters`` with a rate by ``<effect>.<parameter>``.
    """
    checked = [p for o in outcomes for p in o.parameters]
    names = sorted({(p.effect, p.parameter) for p in checked})
    each = {
        f"{effect}.{id}": rate(sum(p.inside for p in group), len(group))
        for effect, id in names
        for group in [[p for p in checked if (p.effect, p.parameter) == (effect, id)]]
    }
    return {"all": rate(sum(p.inside for p in checked), len(checked)), "parameters": each}


def count_settled(first: Sequence[Outcome], again: Sequence[Outcome]) -> Row:
    """Count ambiguous verdicts with a proposed run, and those that are named exactly once that run was made.

    Parameters
    ----------
    first
        Scored cases.
    again
        Cases scored again with the proposed run.

    Returns
    -------
    dict
        Numbers ``ambiguous`` and ``proposed`` of the first; rates ``settled`` and ``settled_wrongly`` of the
        second.
    """
    proposed = [o for o in first if o.verdict == "ambiguous" and o.proposed]
    return {
        "ambiguous": sum(o.verdict == "ambiguous" for o in first),
        "proposed": len(proposed),
        "settled": share_of(again, lambda o: o.result == "named"),
        "settled_wrongly": share_of(again, lambda o: o.result in ("wrong_name", "named_in_part")),
    }


def summary(cases: Sequence[Outcome], left_out: Sequence[Outcome], again: Sequence[Outcome]) -> Row:
    """Return all figures of a study.

    Parameters
    ----------
    cases
        Scored cases.
    left_out
        Cases scored with their true effect left out of the catalogue.
    again
        Ambiguous cases scored with the proposed run.

    Returns
    -------
    dict
        Figures as the study's JSON holds them.
    """
    named = [o for o in cases if o.result == "named"]
    return {
        "results": dict(Counter(o.result for o in cases)),
        "right": share_of(cases, lambda o: o.right),
        "by_kind_and_size": by_kind_and_size(cases),
        "false_alarms": false_alarms(cases),
        "outside_the_catalogue": outside([o for o in cases if o.kind == "unlisted"]),
        "leave_one_out": outside(left_out),
        "settled_by_one_run": count_settled(cases, again),
        "gap_closed_on_unseen_runs": summarise_spread(o.closed for o in named),
        "coverage": coverage(cases),
        "wall_s_per_joint": summarise_spread(o.wall_s for o in cases),
        "simulations_per_joint": summarise_spread(o.simulations for o in cases),
        "confusion": confusion(cases),
        "confusion_leave_one_out": confusion(left_out),
    }
