"""Which effects of the catalogue look alike at small size, on synthetic campaigns in which nothing is hidden.

Signatures are the readings' derivatives with respect to an effect at its neutral value; base parameters and initial
states move the readings too, and what they cannot reach of a signature is D (n_r, amplitudes). Of the part of an
effect's D that another effect follows best, 1 − cos²φ is left over, φ being the least principal angle between both
subspaces (Björck and Golub 1973), the least over all their shapes. Results go to ``docs/results``.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from itertools import combinations
from pathlib import Path
from typing import Any

import click
import numpy as np

from haptid.discrepancy.detect.score_tests import project
from haptid.discrepancy.detect.signatures import signatures
from haptid.discrepancy.fit.nominal_fit import fit_nominal
from haptid.discrepancy.study.study import Study, study_of
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.measurement.values.run import Array
from haptid.model.effects.registry import catalogue
from studies.hidden.run import make_cases
from studies.ledger.version import origin_of, store, tell_origin

OUT = Path(__file__).parents[2] / "docs" / "results" / "lookalikes.json"
CASES, SEED = 8, 11
SHOWN = 0.02
"""Largest share left over that the page shows."""


def subspaces(study: Study) -> dict[str, list[Array]]:
    """Return orthonormal bases (n_r, amplitudes) of every effect's visible signatures, by id."""
    base = fit_nominal(study, starts=4, seed=0).solution
    effects = study.in_si(base.values)
    found = signatures(study, base, list(effects.values()))
    _, D, survives = project(study, base, found)
    bases = defaultdict(list)
    for point in found.points:
        if survives[point.columns].max() > THRESHOLDS.detect.least_share_off_tangent_space:
            U, s, _ = np.linalg.svd(D[:, point.columns], full_matrices=False)
            bases[effects[point.key].id].append(U[:, s > 1e-6 * s[0]])
    return bases


def left_over(one: list[Array], other: list[Array]) -> float:
    """Return the least 1 − cos²φ over all shapes of two effects."""
    nearest = max(float(np.linalg.svd(A.T @ B, compute_uv=False)[0]) for A in one for B in other)
    return max(0.0, 1.0 - nearest**2)


def pairs(folder: Path) -> list[dict[str, Any]]:
    """Return what one effect leaves over of another, case by case, for each pair; the closest first."""
    shares: dict[tuple[str, str], list[float]] = defaultdict(list)
    make_cases(folder, CASES, SEED, kinds=["none"], sizes=["nominal"], inputs="mixed", effects=[])
    for case in sorted(Path(folder, "cases").iterdir()):
        read = campaign_for_command(str(case))
        bases = subspaces(study_of(read, read.joints[0], catalogue()))
        for one, other in combinations(sorted(bases), 2):
            shares[one, other].append(left_over(bases[one], bases[other]))
    ordered = sorted(shares.items(), key=lambda item: min(item[1]))
    return [{"entries": list(pair), "left_over": each} for pair, each in ordered]


def page(stored: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    lines = [
        "# Entries that look alike at small size",
        "",
        f"{CASES} synthetic campaigns in which nothing is hidden, seed {SEED}, Table III and richer inputs.",
        "",
        "What the base's parameters and initial states cannot reach of an entry's signature, and how much of the best "
        "direction in it another entry leaves over: `1 − cos²φ`, φ the least principal angle over all shapes. A gap of "
        "χ² over the noise tells two entries apart where `(1 − cos²φ)·χ²` is well above 10. First order in the size: "
        "at larger sizes entries part further.",
        "",
        tell_origin(stored),
        "",
        f"Pairs of which some campaign leaves less than {SHOWN}; a campaign in which the base alone makes the motion "
        "of an entry is not counted:",
        "",
        "| entries | campaigns | least | median |",
        "| --- | ---: | ---: | ---: |",
    ]
    lines += [
        f"| {', '.join(pair['entries'])} | {len(pair['left_over'])} | {min(pair['left_over']):.1e} | "
        f"{np.median(pair['left_over']):.1e} |"
        for pair in stored["pairs"]
        if min(pair["left_over"]) < SHOWN
    ]
    return "\n".join(lines) + "\n"


@click.command(help=__doc__)
def main() -> None:
    """Compare all pairs, and write results and page."""
    with tempfile.TemporaryDirectory() as folder:
        found = pairs(Path(folder))
    stored = {**origin_of("python -m benchmarks.search.lookalikes"), "pairs": found}
    click.echo(store(OUT, stored, page))


if __name__ == "__main__":
    main()
