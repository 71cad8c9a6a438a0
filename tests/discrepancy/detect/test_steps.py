"""The inner step of the readings."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from haptid.discrepancy.detect import inner_step as steps
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS


@pytest.mark.parametrize(
    ("left", "halvings"),
    [(0.0, 4), (4e5, 4), (1.2e6, 3), (3e7, 1), (1e9, 0)],
    ids=["noise", "a gap", "far", "a stuck base", "any step"],
)
def test_the_error_of_the_step_is_small_beside_what_is_left(
    monkeypatch: pytest.MonkeyPatch, left: float, halvings: int
):
    errors = {THRESHOLDS.study.coarse_step_s / 2**k: 64.0 / 4**k for k in range(6)}
    monkeypatch.setattr(steps, "visible", lambda _study, _solution, step: errors[step])
    solution: Any = SimpleNamespace(chi2=12000.0 + left, residual=np.zeros(12000))
    assert (
        steps.step_for(None, solution, share=THRESHOLDS.detect.step_error_share_of_excess)
        == THRESHOLDS.study.coarse_step_s / 2**halvings
    )
    assert steps.step_for(None, solution) == THRESHOLDS.study.coarse_step_s / 2**4
