"""A name is certain where the runs ask for it throughout, its amplitude is not 0, and no parameter lies on an end."""

from dataclasses import replace

import numpy as np
import pytest

from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.torque.fit import TorqueFit, fit_model
from haptid.discrepancy.torque_search.certain import compute_stability, find_doubted
from haptid.discrepancy.torque_search.search import eliminate
from haptid.model.effects.registry import catalogue
from tests.discrepancy.torque.test_torque import sweep

KEY = "cogging"


def fit_cogging(size: float) -> TorqueFit:
    """Fit waves of the right number to a sweep over 1 rad with white noise of 1 mN m."""
    study = sweep(size, 9.0)
    base = fit_model(study, starts=1, seed=0)
    cogging = catalogue()[KEY].at(study.scales(base.values))
    start = {q.id: q.initial for q in cogging.parameters} | {"cogging_number": 9.0}
    return fit_model(study, (cogging,), base.values | start)


def test_a_wave_that_is_there_is_certain():
    model = fit_cogging(0.02)
    assert compute_stability(model)[KEY] == 1.0
    assert not find_doubted(model, compute_stability(model))


def test_a_name_that_few_bags_keep_is_doubted():
    least = THRESHOLDS.torque.least_stability_of_certain_name
    model = fit_cogging(0.02)
    assert find_doubted(model, {KEY: 0.9 * least}) == {KEY}
    assert not find_doubted(model, {KEY: least})


def test_a_name_with_a_parameter_on_the_end_of_its_range_is_doubted():
    model = fit_cogging(0.02)
    parametrisation = model.problem.parametrisation
    x = model.x.copy()
    at = parametrisation.ids.index("cogging_sin")
    x[at] = model.problem.unknowns_at(ended(model, "cogging_sin"))[at]
    assert find_doubted(replace(model, x=x), {KEY: 1.0}) == {KEY}


def ended(model: TorqueFit, id: str) -> np.ndarray:
    """Return the parameters with one on the upper end of its range."""
    parameters = model.problem.simulator.equations.parameters
    return np.array([q.upper if q.id == id else model.values[q.id] for q in parameters])


@pytest.mark.parametrize(("doubted", "left"), [(frozenset({KEY}), ()), (frozenset(), (KEY,))])
def test_a_doubted_name_stays_only_where_predictions_gain_clearly(
    monkeypatch: pytest.MonkeyPatch, doubted: frozenset[str], left: tuple[str, ...]
):
    model = fit_cogging(0.0015)
    # More standard errors than any gain has: what predictions gain is not clear.
    strict = replace(THRESHOLDS.torque, least_gain_in_standard_errors=1e3)
    monkeypatch.setattr("haptid.discrepancy.torque_search.candidate.THRESHOLDS", replace(THRESHOLDS, torque=strict))
    monkeypatch.setattr("haptid.discrepancy.torque_search.search.find_doubted", lambda *_: doubted)
    final, stability = eliminate(model.study, model, fit_model(model.study), seed=3)
    assert tuple(e.key for e in final.effects) == left
    # What is told of the names is what they were judged by.
    assert stability == compute_stability(final, seed=3)


def test_names_that_leave_more_of_the_held_out_torque_than_none_leave_the_model(monkeypatch: pytest.MonkeyPatch):
    model = fit_cogging(0.02)
    base = fit_model(model.study)
    assert eliminate(model.study, model, base)[0].effects
    # As if every model with effects left more than the nominal one.
    monkeypatch.setattr("haptid.discrepancy.torque_search.search.rms", lambda _: 1.0)
    assert eliminate(model.study, model, base)[0].effects == ()
