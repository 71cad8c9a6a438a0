"""Ranks of truths: uniform ones pass, ones from intervals that are too narrow or shifted raise the alarm."""

import numpy as np
import pytest

from studies.calibration.result import judge_ranks, page, table
from studies.calibration.simulation_based import RANKS, Outcome, coverage

NAMES = ("a", "b")


def outcomes(spread: float, shift: float = 0.0, sets: int = 400) -> list[Outcome]:
    """Truth and draws are standard normal; the draws are ``spread`` times as wide and shifted."""
    rng = np.random.default_rng(0)
    truth, draws = rng.standard_normal((sets, 1, 2)), rng.standard_normal((sets, RANKS, 2))
    ranks = np.sum(shift + spread * draws < truth, axis=1)
    return [Outcome(number=k, ranks=tuple(int(x) for x in r), effective=300.0) for k, r in enumerate(ranks)]


def test_right_posteriors_are_calibrated_and_failures_are_told():
    failed = Outcome(number=400, ranks=None, failure="the truth blew up")
    found = judge_ranks([*outcomes(1.0), failed], NAMES)
    assert found["calibrated"]
    assert found["ranked"] == 400
    assert found["failed"] == [{"set": 400, "why": "the truth blew up"}]
    low, high = found["binomial_band"]["0.95"]
    assert low < found["parameters"]["a"]["coverage"]["0.95"] < high
    assert sum(found["parameters"]["b"]["rank_histogram"]) == 400


@pytest.mark.parametrize(("spread", "shift"), [(0.7, 0.0), (1.5, 0.0), (1.0, 0.4)], ids=["narrow", "wide", "shifted"])
def test_wrong_posteriors_raise_the_alarm(spread, shift):
    found = judge_ranks(outcomes(spread, shift), NAMES)
    assert not found["calibrated"]
    assert "NOT within" in table("4", found)


def test_nominal_coverage_is_a_whole_number_of_ranks():
    for level in (0.5, 0.8, 0.95):
        assert coverage(range(RANKS + 1), level) == pytest.approx(level, abs=1e-12)


def test_the_page_marks_what_is_outside_chance():
    result = {"design": "3 runs", **judge_ranks(outcomes(0.7), NAMES)}
    stored = {
        "command": "python -m studies.calibration.run", "date": "2026-01-01",
        "python": "3.11", "workers": 1, "wall_s": 60.0,
        "priors": "normal", "joints": {"4": result},
    }  # fmt: skip
    text = page(stored)
    assert "## Joint 4" in text
    assert f"**{result['parameters']['a']['coverage']['0.95']:.3f}**" in text
