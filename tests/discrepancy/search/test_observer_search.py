"""Large effects that are chosen under the observer, and names that stand though something is left."""

from pathlib import Path

from haptid.discrepancy.search.forward_selection import fit_nominal_model, score_catalogue, search, under_own_noise
from haptid.discrepancy.search.observer_laws import Led, lead_on
from haptid.discrepancy.search.observer_search import begin_under_observer
from haptid.discrepancy.search.tools import Searcher
from haptid.discrepancy.study.study import Study
from haptid.discrepancy.verdict.verdict import verdict_of
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from tests.discrepancy.finding.test_finding import study_with

KEYS = ("amplifier_dead_band:jump", "gain_drift", "asymmetric_viscous", "cubic_spring", "torque_ripple")
HIDDEN = {"amplifier_dead_band": {"dead_band": 0.0012}, "asymmetric_viscous": {"viscous_asymmetry": 0.6}}


def searched(study: Study) -> Led:
    study, base = fit_nominal_model(study, seed=0, starts=2, tell=ignore_progress)
    white, plain = under_own_noise(study, base)
    entries, found, first = score_catalogue(study, plain, ignore_progress)
    s = Searcher(study, entries, found, first.tests, ignore_progress)
    return lead_on(s, begin_under_observer(s, white), white)


def test_two_large_effects_are_chosen_one_by_one(tmp_path: Path):
    led = searched(study_with(tmp_path / "c", HIDDEN, {key: catalogue()[key] for key in KEYS}))
    assert led.law is None
    best = led.leads[0]
    assert {e.id for e in best.effects} == set(HIDDEN)
    rows = led.at.study.rows
    # The corner of the dead band is still rounded.
    assert best.excess(rows) < 0.02 * led.at.excess


def test_a_name_stands_where_no_other_effect_comes_near_though_something_is_left(tmp_path: Path):
    # The smaller effect is no entry, and no other entry acts as it does.
    entries = {key: catalogue()[key] for key in ("amplifier_dead_band:jump", "torque_ripple", "cubic_spring")}
    hidden = {"amplifier_dead_band": {"dead_band": 0.002}, "asymmetric_viscous": {"viscous_asymmetry": 0.1}}
    study = study_with(tmp_path / "c", hidden, entries)
    found = search(study, starts=2)
    assert not found.best.adequate
    assert found.standing == ("amplifier_dead_band:jump",)
    assert verdict_of(found) == "partly_named"
