"""Verdict on a joint whose torque is scored, from what its names, the best black box and repetition leave."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.finding.gap import Gap
from haptid.discrepancy.finding.torque_finding import TorqueFinding

BEFORE = 50e-3


def finding_that_leaves(after: float, *, floor: float | None, black_box: float | None) -> TorqueFinding:
    """Return a finding with one name that leaves ``after`` of 50 mN m on held-out rows."""
    study = SimpleNamespace(unseen_rows=(), names=lambda _: np.ones(4, dtype=bool))
    final = SimpleNamespace(effects=("one",), unseen=np.full(4, after), study=study)
    return TorqueFinding(
        search=SimpleNamespace(final=final, rivals=()),
        gaps={"validate": Gap(before=BEFORE, after=after, noise=1e-4)},
        regions=(), maps=(), remaining=None, floor=floor, black_box=black_box, nominal_loop=None, final_loop=None,
        fmu=None, considered=1, stability={}, wall_s=0.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("after", "floor", "black_box", "verdict"),
    [
        # What is left repeats no better than the floor.
        (20e-3, 19e-3, 10e-3, "named"),
        # As much closed as the black box closes, and most of what repeats.
        (30e-3, 19e-3, 30e-3, "named"),
        # Most of what repeats, but the black box closes far more.
        (30e-3, 19e-3, 20e-3, "partly_named"),
        # More than the black box, which hardly closes anything, and little of what repeats.
        (45e-3, 19e-3, 49e-3, "partly_named"),
        # Without a second pass all that is left may repeat.
        (45e-3, None, 49e-3, "partly_named"),
        (30e-3, None, 30e-3, "named"),
        (45e-3, None, None, "partly_named"),
    ],
)
def test_names_stand_alone_where_little_that_repeats_is_left(
    after: float, floor: float | None, black_box: float | None, verdict: str
):
    assert finding_that_leaves(after, floor=floor, black_box=black_box).verdict == verdict
