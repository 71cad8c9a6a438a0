"""A name against an element of its kind that is not listed, where the catalogue lacks what it looks like."""

from collections.abc import Collection
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.finding.finding import Finding, as_json, find
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.search.contenders import fit_contenders
from haptid.discrepancy.search.search_result import Search
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.model.effects.effect import w
from haptid.model.effects.parts.cascade import cascade
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.support.listener import ignore_progress
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import study_with
from tests.discrepancy.search.test_search import tools_of

LATE = {"amplifier_lag": ("amplifier_lag", "amplifier_lag:rest"), "time_delay": ("delay", "time_delay")}


def found(tmp_path: Path, hidden: str, seconds: float, without: Collection[str], noise: float = 2e-4) -> Finding:
    effects = {key: catalogue()[key] for id, (_, key) in LATE.items() if id not in without}
    sensor = Sensor(noise=noise, resolution=0.0)
    study = study_with(tmp_path / "c", {hidden: {LATE[hidden][0]: seconds}}, effects, sensor)
    return find(study, tmp_path / "out", kind="python", seed=0, starts=2, tell=ignore_progress)


@pytest.mark.long
@pytest.mark.parametrize("hidden", LATE)
def test_the_only_late_entry_of_a_catalogue_is_not_named_where_another_one_is_as_likely(tmp_path: Path, hidden: str):
    data = as_json(found(tmp_path, hidden, 3e-3, without=[hidden]), measured=False, seed=0)
    assert data["verdict"] == "ambiguous"
    (other,) = set(LATE) - {hidden}
    assert [e["id"] for e in data["effects"]] == [other]
    assert [a["ids"] for a in data["alternatives"]] == [["lag_cascade"]]
    assert "or else lag_cascade (torque that arrives late by two lags in a row, no entry)" in data["sentence"]


@pytest.mark.long
def test_the_only_late_entry_is_unlisted_where_another_one_follows_better(tmp_path: Path):
    finding = found(tmp_path, "amplifier_lag", 3e-3, without=["amplifier_lag"], noise=1e-4)
    assert finding.search.best.adequate
    assert finding.judgement.verdict == "unlisted"
    assert "two lags in a row would follow it better" in finding.judgement.sentence


@pytest.mark.long
def test_with_both_in_the_catalogue_they_contest_each_other(tmp_path: Path):
    finding = found(tmp_path, "amplifier_lag", 6e-3, without=[])
    assert finding.search.contenders == ()
    assert finding.judgement.verdict == "named"
    assert finding.search.best.solution.ids == ("amplifier_lag",)


@pytest.mark.long
@pytest.mark.parametrize(
    ("hidden", "values", "verdict"),
    [
        ("gain_drift", {"gain_rate": 1e-3}, "named"),
        ("gain_drift", {"gain_rate": 2e-5}, "ambiguous"),
        ("thermal_gain", {"heat_gain": 3e-3, "heat_reference": 0.02, "heat_time": 6.0}, "ambiguous"),
        ("thermal_gain", {"heat_gain": 5e-2, "heat_reference": 0.02, "heat_time": 6.0}, "unlisted"),
    ],
)
def test_a_gain_that_drifts_is_told_from_one_that_settles(
    tmp_path: Path, hidden: str, values: dict[str, float], verdict: str
):
    study = study_with(tmp_path / "c", {hidden: values}, {"gain_drift": catalogue()["gain_drift"]}, Sensor(noise=2e-4))
    finding = find(study, tmp_path / "out", kind="python", seed=0, starts=2, tell=ignore_progress)
    assert finding.judgement.verdict == verdict
    if verdict == "ambiguous":
        assert [t.candidate.ids for t in finding.judgement.alternatives] == [("gain_settling",)]


SOFT, CURVED, DRY = "amplifier_saturation:soft", "amplifier_nonlinear_gain", "coulomb_drift:kinetic"


@pytest.mark.long
@pytest.mark.parametrize(
    ("hidden", "values", "key", "contender"),
    [
        ("amplifier_saturation", {"saturation_soft": 0.04}, CURVED, "gain_compression"),
        (CURVED, {"gain_cubic": -0.02, "gain_reference": 0.009}, SOFT, "gain_compression"),
        ("asymmetric_spring", {"spring_quadratic": 2e-4}, "payload_gravity", "even_bend"),
        ("cubic_spring", {"spring_cubic": 2e-4}, "payload_gravity", "odd_bend"),
        ("payload_gravity", {"payload_cos": 1e-4, "payload_sin": 0.0}, "asymmetric_spring", "even_bend"),
        ("payload_gravity", {"payload_cos": 0.0, "payload_sin": 2e-4}, "cubic_spring", "odd_bend"),
        ("coulomb_drift", {"coulomb_warmup": 1.5e-3, "coulomb_warmup_time": 1.5}, "viscous_drift", "friction_warming"),
        ("viscous_drift", {"viscous_warmup": 1e-3, "viscous_warmup_time": 1.5}, DRY, "friction_warming"),
    ],
)
def test_what_looks_like_an_entry_that_is_missing_is_not_named(
    tmp_path: Path, hidden: str, values: dict[str, float], key: str, contender: str
):
    study = study_with(tmp_path / "c", {hidden: values}, {key: catalogue()[key]}, Sensor(noise=2e-4))
    judgement = find(study, tmp_path / "out", kind="python", seed=0, starts=2, tell=ignore_progress).judgement
    assert judgement.verdict == "ambiguous"
    assert [e.key for e in judgement.effects] == [key]
    assert (contender,) in [t.candidate.ids for t in judgement.alternatives]


@pytest.mark.long
@pytest.mark.parametrize(
    ("hidden", "values", "key"),
    [
        ("amplifier_saturation", {"saturation_soft": 0.02}, SOFT),
        (CURVED, {"gain_cubic": -0.1, "gain_reference": 0.009}, CURVED),
        ("asymmetric_spring", {"spring_quadratic": 4e-3}, "asymmetric_spring"),
        ("cubic_spring", {"spring_cubic": 2e-2}, "cubic_spring"),
        ("payload_gravity", {"payload_cos": 3e-3, "payload_sin": 1e-3}, "payload_gravity"),
        ("coulomb_drift", {"coulomb_warmup": 1e-2, "coulomb_warmup_time": 1.5}, DRY),
        ("viscous_drift", {"viscous_warmup": 1e-2, "viscous_warmup_time": 1.5}, "viscous_drift"),
    ],
)
def test_an_effect_that_beats_its_contenders_is_named(tmp_path: Path, hidden: str, values: dict[str, float], key: str):
    study = study_with(tmp_path / "c", {hidden: values}, {key: catalogue()[key]}, Sensor(noise=2e-4))
    finding = find(study, tmp_path / "out", kind="python", seed=0, starts=2, tell=ignore_progress)
    assert finding.search.contenders
    assert finding.judgement.verdict == "named"
    assert finding.search.best.solution.keys == (key,)


def test_the_cascade_answers_a_step_as_two_equal_lags_do():
    """1 − (1 + 2t/T)·e^(−2t/T), Laplace transform of 1/(s·(1 + sT/2)²)."""
    T, t = 0.05, np.linspace(0.0, 0.3, 61)
    effect = cascade(sp.Float(1e-4))
    states = [x.state.symbol for x in effect.states]
    symbols = (w, effect.parameters[0].symbol, *states)
    rates = sp.lambdify(symbols, [x.rhs for x in effect.states])
    late = sp.lambdify(symbols, effect.input)
    x = solve_ivp(lambda _, x: rates(1.0, T, *x), (0.0, t[-1]), (0.0, 0.0), t_eval=t, rtol=1e-9, atol=1e-12).y
    expected = 1.0 - (1.0 + 2.0 * t / T) * np.exp(-2.0 * t / T)
    np.testing.assert_allclose(late(1.0, T, *x), expected, atol=1e-7)
    assert late(1.0, 0.0, 0.3, 0.2) == 1.0


@pytest.mark.long
def test_a_contender_is_tried_without_what_makes_up_for_the_named_entry(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A weight beside which a wave makes up for the rest of a cubic spring: the bend alone does as well."""
    keys = ("payload_gravity", "cogging")
    study = study_with(
        tmp_path / "c", {"cubic_spring": {"spring_cubic": 0.02}}, {key: catalogue()[key] for key in keys}
    )
    s, start = tools_of(study, starts=2)
    weight = solve(study, [s.catalogue[keys[0]]], Noise(), start.solution.values, x0=start.solution.x0)
    both = solve(study, [s.catalogue[key] for key in keys], Noise(), weight.values, x0=weight.x0)
    best = judge_candidate(s, settle(study, both.effects, both), start.candidate)
    with monkeypatch.context() as patch:
        patch.setattr(Trial, "adequate", property(lambda _: True))
        made = {t.solution.ids: t for t in fit_contenders(s, best, start)}
    assert set(made) >= {("cogging", "odd_bend"), ("odd_bend",)}
    assert made["odd_bend",].adequate
    assert made["odd_bend",].candidate.criterion < best.candidate.criterion


@pytest.mark.parametrize(("ahead", "beaten"), [(30.0, True), (5.0, False), (np.nan, False)])
def test_a_contender_that_follows_better_beats_a_name_though_it_leaves_more_than_noise(ahead: float, beaten: bool):
    """A drift of both frictions was 271 better than three stand-ins that left only noise; one of them drifted."""
    best = SimpleNamespace(candidate=SimpleNamespace(criterion=0.0), adequate=True)
    contender = SimpleNamespace(candidate=SimpleNamespace(criterion=-ahead), adequate=False)
    found = SimpleNamespace(best=best, contenders=(contender,))
    assert Search.beaten_by.fget(found) is (contender if beaten else None)
