"""What a calibration says: rank histograms, χ² and coverage of every parameter, as numbers, text and a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import binom, binomtest, chisquare

from studies.calibration.simulation_based import Outcome, chi_square_bins, coverage
from studies.ledger.version import tell_version

LEVELS = (0.5, 0.8, 0.95)
BINS = 10
FAMILY = 0.05
"""Chance of any alarm at all among all tests of a joint, were every interval right (Bonferroni)."""


def judge_ranks(outcomes: Sequence[Outcome], names: Sequence[str]) -> dict[str, Any]:
    """Judge the ranks of every parameter by histogram, χ² p-value and coverage, with their binomial p-values.

    Parameters
    ----------
    outcomes
        Data sets of one joint.
    names
        Coordinates in the order of the ranks.

    Returns
    -------
    dict
        Entry of the joint in the result's JSON; ``calibrated`` where the smallest p-value is not below
        ``alarm_below``.
    """
    ranked = [o for o in outcomes if o.ranks is not None]
    made: dict[str, Any] = {
        "ranked": len(ranked),
        "failed": [{"set": o.number, "why": o.failure} for o in outcomes if o.ranks is None],
        "independent_draws": {
            "fewest": float(min((o.effective for o in ranked), default=0.0)),
            "median": float(np.median([o.effective for o in ranked] or [0.0])),
        },
        "binomial_band": {f"{p:g}": _band(len(ranked), p) for p in LEVELS},
        "parameters": {name: _one([o.ranks[i] for o in ranked if o.ranks]) for i, name in enumerate(names)},
    }
    tests = [p for found in made["parameters"].values() for p in (found["chi_square_p"], *found["binomial_p"].values())]
    made["tests"] = len(tests)
    made["smallest_p"] = float(min(tests, default=1.0))
    made["alarm_below"] = FAMILY / max(len(tests), 1)
    made["calibrated"] = made["smallest_p"] >= made["alarm_below"]
    return made


def _one(ranks: Sequence[int]) -> dict[str, Any]:
    counts = chi_square_bins(ranks, bins=BINS)
    hits = {p: round(coverage(ranks, p) * len(ranks)) for p in LEVELS}
    return {
        "rank_histogram": counts.astype(int).tolist(),
        "chi_square_p": float(chisquare(counts).pvalue),
        "coverage": {f"{p:g}": hits[p] / len(ranks) for p in LEVELS},
        "binomial_p": {f"{p:g}": float(binomtest(hits[p], len(ranks), p).pvalue) for p in LEVELS},
    }


def _band(count: int, level: float) -> list[float]:
    """Central 95 % range of a coverage counted on ``count`` data sets where the interval is right."""
    return [float(binom.ppf(q, count, level)) / max(count, 1) for q in (0.025, 0.975)]


def table(joint: str, result: dict[str, Any]) -> str:
    """Lay the result of one joint out as text.

    Parameters
    ----------
    joint
        Number of the joint.
    result
        As `judge_ranks` returns it.

    Returns
    -------
    str
        A line for each parameter, between a head and the verdict.
    """
    lines = [f"joint {joint}: {result['ranked']} data sets ranked, {len(result['failed'])} failed"]
    for name, found in result["parameters"].items():
        shares = "  ".join(f"{level}: {share:.3f}" for level, share in found["coverage"].items())
        lines.append(f"  {name:14s} χ² p = {found['chi_square_p']:.3f}   coverage {shares}")
    return "\n".join([*lines, "  " + verdict(result)])


def verdict(result: dict[str, Any]) -> str:
    """Say in one sentence whether anything departs from nominal by more than chance allows.

    Parameters
    ----------
    result
        As `judge_ranks` returns it.

    Returns
    -------
    str
    """
    numbers = (
        f"smallest of {result['tests']} p-values {result['smallest_p']:.2g}, alarm below {result['alarm_below']:.2g}"
    )
    return f"{'Within' if result['calibrated'] else 'NOT within'} the error of counting: {numbers}."


def page(stored: dict[str, Any]) -> str:
    """Render the stored result as a page of the documentation.

    Parameters
    ----------
    stored
        Content of the result's JSON.

    Returns
    -------
    str
        Markdown.
    """
    text = "# Are the printed intervals right?\n\n" + (
        f"`{stored['command']}`, {stored['date']}, {tell_version(stored)}, Python {stored['python']}, "
        f"{stored['wall_s'] / 60:.0f} minutes with {stored['workers']} process. The same numbers: `calibration.json` "
        "beside this page.\n\n"
        "Truths are drawn from the priors, data from the model, and each truth is ranked among draws of its posterior "
        "(simulation-based calibration: Talts, Betancourt, Simpson, Vehtari, Gelman 2018). Where the software is "
        "right, ranks are uniform and a p-interval holds the truth in a share p of the data sets. The path is the "
        "command's: mode, normal approximation, ensembles, marginal likelihood with noise factor and amplitude "
        "scatter.\n\n"
        f"Priors: {stored['priors']}.\n\n"
    )
    text += "".join(f"{note}\n\n" for note in stored.get("notes", ()))
    return text + "\n".join(_joint(joint, result) for joint, result in stored["joints"].items())


def _joint(joint: str, result: dict[str, Any]) -> str:
    band = {level: f"{low:.3f} to {high:.3f}" for level, (low, high) in result["binomial_band"].items()}
    header = ["parameter", *(f"{100 * float(p):.0f} % interval holds" for p in band), "χ² p", "ranks, ten bins"]
    rows = [["*expected*", *band.values(), "", f"{result['ranked'] / BINS:g} each"]]
    for name, found in result["parameters"].items():
        shares = [_mark_outside_band(found["coverage"][p], *result["binomial_band"][p]) for p in band]
        counts = " ".join(map(str, found["rank_histogram"]))
        rows.append([f"`{name}`", *shares, f"{found['chi_square_p']:.2f}", counts])
    lines = ["| " + " | ".join(line) + " |" for line in (header, ["---"] * len(header), *rows)]
    draws = result["independent_draws"]
    told = (
        f"{verdict(result)} {result['ranked']} data sets, {len(result['failed'])} failed; independent draws per data "
        f"set {draws['median']:.0f} in the median, {draws['fewest']:.0f} at least. Bold: outside the central 95 % "
        "range of chance, as one in twenty should be. Each data set: "
        f"{result['design']}.\n"
    )
    return "\n".join([f"## Joint {joint}\n", told, *lines, ""])


def _mark_outside_band(share: float, low: float, high: float) -> str:
    return f"{share:.3f}" if low <= share <= high else f"**{share:.3f}**"
