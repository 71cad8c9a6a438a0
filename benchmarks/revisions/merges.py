"""Merges on the page: what was measured of each pair of commits in, the tables of the page out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.revisions.cases import CASES, Case
from benchmarks.revisions.differences import (
    better,
    distance_from_truth,
    largest_in_errors,
    largest_of_parameters,
    largest_of_unseen,
    rms_of_unseen,
)
from docs.parts.tables import table

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NOT_HELD = "not held"
MOST_DIGITS = 12
NEGLIGIBLE_ERRORS = 0.01
"""Standard errors [1] below which parameters are apart by less than any run can tell, so that no side is better."""
BY_CASE: Mapping[str, Case] = {case.name: case for case in CASES}


def merges_section(stored: Mapping[str, Any]) -> str:
    """Return the part of the page on merges.

    Parameters
    ----------
    stored
        With ``merges``, what is on record of each, ``pairs``, what was measured of pairs of commits, and ``truth``,
        parameters of joint 4 of the virtual device.

    Returns
    -------
    str
        Markdown: one table over all merges, and one over the pairs that were measured and differ.
    """
    pairs = {pair["after"]: pair for pair in stored["pairs"]}
    rows = []
    for merge in stored["merges"]:
        pair = pairs.get(merge["commit"])
        if pair is None:
            rows.append((merge["merge"], merge["commit"], merge["held"], merge["real"]))
            continue
        embedded = [result_in_words(held) for held in cases_of(pair, real=False)]
        real = [result_in_words(held) for held in cases_of(pair, real=True)]
        if merge["held"]:
            embedded.append(f"at the time: {merge['held']}")
        rows.append((merge["merge"], merge["commit"], "; ".join(embedded), "; ".join(real) or NOT_HELD))
    header = ("merge", "commit", "held against what it replaces", "on the real sets")
    return "\n".join(
        [
            "## Merges",
            "",
            "Each merge is a commit, and the commit before it holds what the merge replaces. Both ran the same "
            "commands with the same libraries: `python -m benchmarks.same_results --merge COMMIT`. *The same* means "
            "JSON that is equal to the last bit but for what tells of the run. Where it is not, the largest relative "
            "differences stand here, and the next table says which side was right. A search is stopped after "
            f"{CASES[1].limit_s:.0f} s. Campaigns of real sets are written by the revision's own code where it has "
            "such code (from 8050fbca on), else by the present one. "
            f"{_needs_in_words(stored['pairs'])}Where nothing was measured, the record of that time stands alone. "
            "What the present code reaches on the real sets: [real machines](real_machines.md).",
            "",
            table(header, rows),
            "## Which side was right",
            "",
            "Each result whose parameters or RMS are not the same, before and after. From the truth: the RMS of the "
            "relative errors of all parameters that the fit determines, beside those of the virtual device. On unseen: "
            "the RMS of the residual on runs or rows that no fit saw [rad, m, N m or N]. Nearer or lower is better; "
            f"where all parameters are less than {NEGLIGIBLE_ERRORS:g} standard errors apart, neither is.",
            "",
            differing_table(stored),
        ]
    )


def _needs_in_words(pairs: Sequence[Mapping[str, Any]]) -> str:
    """Say which packages revisions need beside the present requirements; nothing where none does."""
    needs: dict[str, list[str]] = {}
    for pair in pairs:
        for package in pair["packages"]:
            needs.setdefault(package, []).append(pair["after"])
    words = [f"{package} was installed beside them for {', '.join(commits)}" for package, commits in needs.items()]
    return f"{'; '.join(words)}. " if words else ""


def cases_of(pair: Mapping[str, Any], *, real: bool) -> list[Mapping[str, Any]]:
    """Return what was measured of a pair, on real sets or on the embedded campaign."""
    return [held for held in pair["cases"] if BY_CASE[held["case"]].real is real]


def result_in_words(held: Mapping[str, Any]) -> str:
    """Say of one command on both sides whether its results are the same, and else how far apart they are."""
    title = BY_CASE[held["case"]].title
    ends = {side: held[side]["outcome"] for side in ("before", "after") if held[side]["outcome"] != "done"}
    if ends:
        return f"{title}: " + ", ".join(f"{outcome} {side}" for side, outcome in ends.items())
    if held["same"]:
        return f"{title}: the same"
    before, after = held["before"]["figures"], held["after"]["figures"]
    if figures_agree(before, after):
        numbers = held["numbers"]
        place = numbers["name"].removeprefix("configurations.0.")
        return (
            f"{title}: the same parameters and RMS, other numbers by up to {power(numbers['difference'])} (`{place}`)"
        )
    return f"{title}: {', '.join(apart_in_words(before, after))}"


def figures_agree(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Say whether two results agree in verdict, values of parameters and RMS on unseen runs, to the last bit."""
    keys = ("verdict", "effects", "unseen")
    values = [{id: row[0] for id, row in side["parameters"].items()} for side in (before, after)]
    return values[0] == values[1] and all(before.get(key) == after.get(key) for key in keys)


def apart_in_words(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Say by how much the figures of two results differ."""
    words = []
    if "verdict" in before:
        names = [f"{side['verdict']} ({', '.join(side['effects']) or 'no effect'})" for side in (before, after)]
        words.append("the same verdict and effects" if names[0] == names[1] else f"{names[0]} before, {names[1]} after")
    parameters, errors = largest_of_parameters(before, after), largest_in_errors(before, after)
    if parameters.name:
        in_errors = f", {power(errors.difference)} standard errors" if errors.name else ""
        words.append(f"parameters by up to {power(parameters.difference)}{in_errors}")
    if set(before["parameters"]) != set(after["parameters"]):
        words.append("not the same parameters identifiable")
    unseen = largest_of_unseen(before, after)
    if unseen.name:
        words.append(f"RMS on unseen runs by up to {power(unseen.difference)}")
    return words


def differing_table(stored: Mapping[str, Any]) -> str:
    """Return the table of results that are not the same: distances from the truth and RMS on unseen runs."""
    rows: list[Sequence[str]] = []
    for pair in stored["pairs"]:
        for held in pair["cases"]:
            if "numbers" not in held or figures_agree(held["before"]["figures"], held["after"]["figures"]):
                continue
            rows.append((f"{pair['before']} to {pair['after']}", *_sides(held, stored["truth"])))
    header = ("commits", "command", "cost before, after", "from the truth", "RMS on unseen", "better")
    return table(header, rows) if rows else "None differs.\n"


def _sides(held: Mapping[str, Any], truth: Mapping[str, float]) -> tuple[str, ...]:
    case = BY_CASE[held["case"]]
    sides = [held["before"]["figures"], held["after"]["figures"]]
    distances = [None if case.real else distance_from_truth(side, truth) for side in sides]
    unseen = [rms_of_unseen(side) for side in sides]
    judged = []
    errors = largest_in_errors(*sides)
    if errors.name and errors.difference < NEGLIGIBLE_ERRORS:
        return (
            case.title,
            *_cells(sides, distances, unseen),
            f"neither: {power(errors.difference)} standard errors apart",
        )
    if nearer := better(*distances):
        judged.append(f"{nearer} (truth)")
    if lower := better(*unseen):
        judged.append(f"{lower} (unseen)")
    return (case.title, *_cells(sides, distances, unseen), ", ".join(judged) or "neither")


def _cells(sides: Sequence[Mapping[str, Any]], *pairs: Sequence[float | None]) -> list[str]:
    costs = [side.get("cost") for side in sides]
    return [_two_numbers(*pair) for pair in (costs, *pairs)]


def _two_numbers(before: float | None, after: float | None) -> str:
    """Write two numbers with four digits, and with more where these would hide a difference; nothing without both."""
    if before is None or after is None:
        return ""
    digits = 4
    while digits < MOST_DIGITS and before != after and f"{before:.{digits}g}" == f"{after:.{digits}g}":
        digits += 1
    return f"{before:.{digits}g}, {after:.{digits}g}"


def power(value: float) -> str:
    """Write a number with two digits, a small one with a power of ten.

    Examples
    --------
    >>> power(0.013), power(3.04e-7), power(0.0)
    ('0.013', '3.0·10⁻⁷', '0')
    """
    if value == 0.0:
        return "0"
    if 1e-3 <= value < 1e4:
        return f"{value:.2g}"
    digits, _, exponent = f"{value:.1e}".partition("e")
    return f"{digits}·10{str(int(exponent)).translate(SUPERSCRIPT)}"
