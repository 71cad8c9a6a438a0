"""Shares of a gap that are told."""

from __future__ import annotations

import pytest

from haptid.discrepancy.finding.gap import Gap, tell_share


@pytest.mark.parametrize(
    ("beside", "share"),
    [(None, 0.5), ((3.0, 1.2), 0.9), ((3.0, 0.98), 1.0), ((3.0, 0.2), 0.5), ((1.02, 1.0), None)],
    ids=["no scatter", "part", "all", "scatter takes more than the noise", "no gap beside the scatter"],
)
def test_no_share_beside_the_scatter_is_above_one(beside: tuple[float, float] | None, share: float | None):
    gap = Gap(before=3.0, after=2.0, noise=1.0, beside=beside)
    assert gap.closed_beside_scatter == (None if share is None else pytest.approx(share))
    assert {"floor", "black_box"} <= set(gap.as_json())


@pytest.mark.parametrize(("share", "words"), [(None, "–"), (0.5, "50.0 %"), (1.12, "100.0 %"), (-0.2, "-20.0 %")])
def test_no_more_than_all_of_a_gap_is_closed(share: float | None, words: str):
    assert tell_share(share) == words


def test_a_gap_that_grows_is_not_closed_whatever_scatter_makes_of_it():
    gap = Gap(before=0.0122, after=0.113, noise=0.00015, beside=(3.0, 2.6))
    assert gap.closed_beside_scatter == gap.closed
    assert gap.closed is not None
    assert gap.closed < 0


def test_an_rms_that_grows_by_scatter_alone_has_the_share_beside_it():
    gap = Gap(before=1.31e-3, after=1.39e-3, noise=0.2e-3, beside=(2.45, 0.998))
    assert gap.closed_beside_scatter == pytest.approx(1.0)
