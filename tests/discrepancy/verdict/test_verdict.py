"""The verdict rests on honest errors, not on the curvature that the search relies on."""

from pathlib import Path

import numpy as np
import pytest

from haptid.discrepancy.search.forward_selection import search
from haptid.discrepancy.verdict.verdict import judge, untold
from haptid.model.effects.registry import catalogue
from tests.discrepancy.finding.test_finding import study_with


def test_a_name_whose_first_amplitude_cannot_be_told_from_nothing_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slack of 17 ± 14 µrad had been named where an elastic tendon was missing in the catalogue."""
    study = study_with(tmp_path, {"time_delay": {"delay": 0.01}}, {"time_delay": catalogue()["time_delay"]})
    found = search(study, starts=2)
    named = judge(study, found)
    assert named.verdict == "named"

    rough = np.full(found.best.solution.theta.size, 0.005)
    monkeypatch.setattr("haptid.discrepancy.verdict.verdict.standard_errors", lambda _, solution, __: (solution, rough))
    refused = judge(study, found)
    assert refused.verdict == "unlisted"
    assert refused.sentence.endswith("It is like time_delay (torque that arrives late), but delay_time may be 0.")
    assert refused.shape is not None

    solution, least = found.best.solution, np.sqrt(np.log(study.rows))
    value = solution.values["delay_time"]
    assert untold(solution, np.full_like(rough, 1.01 * value / least), study.rows) == ("delay_time",)
    assert untold(solution, np.full_like(rough, 0.99 * value / least), study.rows) == ()
