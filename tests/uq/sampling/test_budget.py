"""Short chains whose steps simulate much have fewer of them, and say so."""

import pytest

from haptid.uq.result.infer import QUICK
from haptid.uq.sampling.budget import shorten, tell_shortened
from haptid.uq.sampling.sampling import walkers_of
from haptid.uq.thresholds import THRESHOLDS


def test_short_chains_stay_as_they_are_where_a_density_is_cheap():
    taken = shorten(QUICK, 16_000, 14)
    assert taken == QUICK
    assert tell_shortened(QUICK, taken, 16_000) == ""


@pytest.mark.parametrize("inner_steps", [48_000, 60_000, 100_000])
def test_short_chains_keep_to_their_bound(inner_steps):
    taken = shorten(QUICK, inner_steps, 15)
    simulated = (taken.burn + taken.longest) * taken.ensembles * walkers_of(15) * inner_steps
    assert simulated == pytest.approx(THRESHOLDS.most_inner_steps_of_short_chains, rel=0.05)
    assert (taken.ensembles, taken.longest) == (2, 3 * taken.chunk)
    told = tell_shortened(QUICK, taken, inner_steps)
    head = f"2 ensembles of {taken.longest} steps after {taken.burn} of burn-in, in place of 4 of 120 after 60: "
    assert told.startswith(head)
    assert f"{inner_steps} inner steps" in told


def test_ensembles_are_given_up_before_steps():
    taken = shorten(QUICK, 30_000, 15)
    assert (taken.ensembles, taken.burn, taken.chunk, taken.longest) == (2, 60, 40, 120)


def test_chains_are_never_shorter_than_a_share_of_short_ones():
    taken = shorten(QUICK, 10_000_000, 15)
    assert (taken.burn, taken.chunk, taken.longest) == (20, 13, 39)
