"""Which effects of the catalogue look alike at small size, on synthetic campaigns in which nothing is hidden.

Signatures are the readings' derivatives with respect to an effect at its neutral value; base parameters and initial
states move the readings too, and what they cannot reach of a signature is D (n_r, amplitudes). Of the part of an
effect's D that another effect follows best, 1 − cos²φ is left over, φ being the least principal angle between both
subspaces (Björck and Golub 1973), the least over all their shapes.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from itertools import combinations
from pathlib import Path

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

CASES, SEED = 8, 11
SHOWN = 0.02
"""Largest share left over that is printed."""


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


def main() -> None:
    """Print pairs of effects of which one follows the other but for a small share, case by case."""
    shares: dict[tuple[str, str], list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        make_cases(Path(folder), CASES, SEED, kinds=["none"], sizes=["nominal"], inputs="mixed", effects=[])
        for case in sorted(Path(folder, "cases").iterdir()):
            read = campaign_for_command(str(case))
            bases = subspaces(study_of(read, read.joints[0], catalogue()))
            for one, other in combinations(sorted(bases), 2):
                shares[one, other].append(left_over(bases[one], bases[other]))
    print(f"{'entries':56s}{'cases':>6s}{'least':>10s}{'median':>10s}")
    for pair, each in sorted(shares.items(), key=lambda item: min(item[1])):
        if min(each) < SHOWN:
            print(f"{' and '.join(pair):56s}{len(each):6d}{min(each):10.1e}{np.median(each):10.1e}")


if __name__ == "__main__":
    main()
