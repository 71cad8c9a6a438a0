"""The proposed run, in words that say how often it is needed."""

import pytest

from discrepancy.next_experiment import MANY, Proposal


@pytest.mark.parametrize(("separation", "repeats"), [(1.0, 1), (0.1, 2), (0.05, 8), (0.0, 20_000_000)])
def test_evidence_grows_with_the_square_of_the_separation_and_with_the_readings(separation: float, repeats: int):
    proposal = Proposal(amplitude=0.01, frequency=3.0, offset=0.0, separation=separation, rows=1001)
    assert proposal.repeats == repeats
    words = proposal.as_json()["run"]
    assert (f"{repeats} times" in words) == (1 < repeats <= MANY)
    assert ("no run within these limits" in words) == (repeats > MANY)
