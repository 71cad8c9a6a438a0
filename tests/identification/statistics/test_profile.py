"""Profile likelihoods against refits with the parameter fixed, and against straight valleys."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from haptid.identification.fit.multistart import fit
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.statistics.profile_likelihood import LEVEL
from tests.identification.bench_joint import TRUE, equations, runs, simulator

OPTIONS = FitOptions(method="gauss_newton", starts=2, profile=True)


@pytest.fixture(scope="module")
def found():
    return fit(simulator(), runs(), options=OPTIONS)


def test_intervals_hold_the_estimate_and_follow_the_curvature_where_the_valley_is_straight(found):
    assert set(found.profiles) == set(found.free)
    for id in ("sigma2", "Fc", "sigma0", "vs"):
        one, value, std = found.profiles[id], found.values[id], found.std[found.index(id)]
        assert one.lower is not None
        assert one.upper is not None
        np.testing.assert_allclose([value - one.lower, one.upper - value], 1.96 * std, rtol=0.1)
        assert one.lower - std < TRUE[id] < one.upper + std


@pytest.mark.parametrize("id", ["sigma0", "Fc"])
def test_at_its_ends_a_refit_costs_what_the_level_says(found, id):
    """The parameter fixed at the end of its interval in other equations, everything else fitted anew by SLSQP.

    The paper's weights, 1/2 on the first half of a run, make f between 1/2 and 1 for white residuals.
    """
    weight = Problem.of(simulator(), tuple(run for run in runs() if run.use == "fit"), OPTIONS).weight
    rises = []
    for end in (found.profiles[id].lower, found.profiles[id].upper):
        pinned = equations().with_parameters({id: {"initial": end, "fixed": True}})
        start = tuple(end if q.id == id else found.values[q.id] for q in pinned.parameters)
        options = FitOptions(starts=1, start=start, gains=(0.0,))
        rises.append((fit(replace(simulator(), equations=pinned), runs(), options=options).cost - found.cost) * weight)
    assert 0.5 * LEVEL < min(rises) <= max(rises) < LEVEL
    assert max(rises) / min(rises) == pytest.approx(1.0, abs=0.05)


def test_an_interval_that_a_bound_ends_is_open(found):
    """With its upper bound just above the estimate the parameter has no upper end."""
    value, std = found.values["vs"], found.std[found.index("vs")]
    near = equations().with_parameters({"vs": {"upper": value + 0.5 * std, "initial": value}})
    start = tuple(found.values[q.id] for q in near.parameters)
    one = fit(
        replace(simulator(), equations=near),
        runs(),
        options=OPTIONS.but(starts=1, start=start, gains=(0.0,)),
    ).profiles["vs"]
    assert one.upper is None
    assert one.lower == pytest.approx(found.profiles["vs"].lower, rel=1e-3)
