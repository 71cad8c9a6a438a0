"""A name is certain only where the runs tell it from what could stand in its place."""

from dataclasses import replace

import pytest

from haptid.discrepancy.torque.fit import fit_model
from haptid.discrepancy.torque_search.candidate import compare_candidates
from haptid.discrepancy.torque_search.rivals import find_rivals
from haptid.discrepancy.torque_search.search import TorqueSearch, search_torque
from haptid.model.effects.effect import Effect
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from tests.discrepancy.torque.test_torque import sweep

KEYS = ("cogging", "cubic_spring", "asymmetric_spring")


@pytest.mark.parametrize(("waves", "size"), [(2.5, 0.0015), (2.0, 0.0015), (2.0, 0.0025)])
def test_less_than_half_a_wave_in_noise_could_be_a_bent_spring(waves: float, size: float):
    found = search(waves, size)
    (named,) = found.final.effects
    assert found.rivals
    assert "cogging" in {named.id, *(rival.key for rival in found.rivals)}
    assert all(rival.replaces == named.key for rival in found.rivals)


@pytest.mark.parametrize(("waves", "size"), [(9.0, 0.001), (2.5, 0.02)])
def test_a_wave_that_the_noise_does_not_hide_has_no_rival(waves: float, size: float):
    found = search(waves, size)
    assert [effect.id for effect in found.final.effects] == ["cogging"]
    assert found.rivals == ()


def test_a_rival_does_not_keep_what_elimination_left_out():
    study = sweep(0.0015, 2.5)
    base = fit_model(study, starts=1, seed=0)
    scales = study.scales(base.values)
    cogging, cubic, asymmetric = (catalogue()[key].at(scales) for key in KEYS)
    early = fit_model(study, (cubic,), base.values | starts_of(cubic))
    taken, other = (
        compare_candidates(new.key, early, fit_model(study, (cubic, new), early.values | starts_of(new)))
        for new in (cogging, asymmetric)
    )
    final = fit_model(study, (cogging,), taken.model.values)
    rivals = find_rivals(study, final, [(taken, [replace(other, bic=1.0, evidence=100.0, errors_gained=100.0)])])
    assert [[effect.key for effect in rival.model.effects] for rival in rivals] == [["asymmetric_spring"]]


def starts_of(effect: Effect) -> dict[str, float]:
    return {q.id: q.initial for q in effect.parameters}


def search(waves: float, size: float) -> TorqueSearch:
    """Search in a sweep over 1 rad with white noise of 1 mN m."""
    listed = {key: effect for key, effect in catalogue().items() if key in KEYS}
    return search_torque(sweep(size, waves), listed, starts=1, seed=0, tell=ignore_progress)
