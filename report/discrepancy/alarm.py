"""What a finding rests on where its residual is the noise: `Finding` in, a sentence for its first screen out.

Tests of the whole residual see a regularity far below the sensor's noise, which no RMS shows.
"""

from __future__ import annotations

import math

from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.finding.finding import Finding
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.units import unit_for
from haptid.report.common.numbers import in_thousandths
from haptid.support.numbers import plain

TESTS = {
    "repeating": "a residual that repeats with the drive",
    "drifting": "a residual on the drive's harmonics that changes along the runs",
    "band": "a residual at low frequencies",
    "line": "one frequency that stands out of the residual",
}
"""What each part of the omnibus test finds, by its name there."""


def tell_small_alarm(finding: Finding) -> str:
    """Say which test found something, and how small it is, where the simulation misses the runs by the noise alone.

    Parameters
    ----------
    finding
        Result of the search.

    Returns
    -------
    str
        Empty where the residual is above the noise, or nothing without a name is missing.
    """
    judgement = finding.judgement
    if judgement.verdict not in ("unlisted", "partly_named"):
        return ""
    name = next(name for name in ("sealed", "validate", "fit") if name in finding.gaps)
    gap = finding.gaps[name]
    left = gap.after if judgement.effects else gap.before
    if left > THRESHOLDS.largest_residual_as_noise * gap.noise:
        return ""
    best = finding.search.best
    test, p = _strongest_test(finding.search.before if best.adequate else best)
    runs = "The fitted runs are" if name == "fit" else "Runs that no fit saw are"
    unit = unit_for("rad", finding.search.study.fitted[0].prismatic)
    over = plain(left / gap.noise, 3)
    return (
        f"{runs} missed by no more than the sensor's noise ({over} × noise): this rests on {test} (p = {p:.1g}) in the "
        f"fitted runs, which miss {_tell_excess(finding, unit)}. A simulation hardly gains by it."
    )


def _strongest_test(trial: Trial) -> tuple[str, float]:
    """Return what the test with the smallest p found, and its p; NaN stands for a test that was not made."""
    part = min(trial.left.parts, key=lambda name: trial.left.parts[name], default="")
    found = {
        TESTS.get(part, "a residual that is not white"): trial.left.p,
        "scores of the catalogue": trial.left_p,
        "parameters that differ between the runs": trial.constant_p,
    }
    made = {test: p for test, p in found.items() if not math.isnan(p)}
    test = min(made, key=lambda name: made[name])
    return test, made[test]


def _tell_excess(finding: Finding, unit: str) -> str:
    """Say by how much more than the noise the fitted runs are missed, as an RMS."""
    gap = finding.gaps["fit"] if "fit" in finding.gaps else next(iter(finding.gaps.values()))
    rms = gap.after if finding.judgement.effects else gap.before
    excess = math.sqrt(max(rms**2 - gap.noise**2, 0.0))
    if excess == 0.0:
        return "no more than the noise either"
    return f"{in_thousandths(excess, unit)} (RMS) beside the noise of {in_thousandths(gap.noise, unit)}"
