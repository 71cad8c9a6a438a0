"""Ripple of gear teeth and poles: waves over position that no grid of the catalogue holds."""

from dataclasses import replace

import numpy as np
import pytest

from haptid.discrepancy.detect.waves import find_waves
from haptid.discrepancy.study.study import usable
from haptid.discrepancy.torque.fit import fit_model
from haptid.discrepancy.torque_search.search import search_torque
from haptid.model.effects.registry import catalogue
from haptid.model.friction.registry import law_named
from haptid.support.linear_algebra import rms
from haptid.support.listener import ignore_progress
from tests.discrepancy.torque.test_torque import sweep

KEYS = (
    "cogging",
    "cogging:harmonics",
    "position_dependent_friction:harmonics",
    "cubic_spring",
    "position_dependent_friction:wave",
    "quadratic_drag",
)


def positions(rng: np.random.Generator) -> np.ndarray:
    return np.concatenate([np.linspace(0.0, 2.0, 4000), np.linspace(2.0, 0.0, 4000)]) + 1e-5 * rng.normal(size=8000)


def test_a_wave_is_found_between_the_waves_of_the_travel():
    rng = np.random.default_rng(0)
    q = positions(rng)
    signal = 0.1 * np.sin(202.3 * q + 1.0) + 0.2 * rng.normal(size=q.size)
    (found, *_) = find_waves(q, signal[:, None], beyond=20.0)
    assert found == pytest.approx(202.3, abs=0.5)


def test_noise_white_or_slow_shows_no_wave():
    found = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        white = rng.normal(size=8000)
        slow = np.convolve(white, np.exp(-np.arange(200) / 40.0), mode="same")
        found += bool(find_waves(positions(rng), np.column_stack((white, slow)), beyond=20.0))
    # One set in 500 is expected, as each has two signals at a probability of 0.001.
    assert found <= 3


@pytest.mark.long
@pytest.mark.parametrize(
    ("slides", "size", "named"), [(False, 0.01, ["cogging"]), (True, 0.01, ["cogging"]), (False, 0.0, [])]
)
def test_gear_ripple_is_named_and_a_sweep_without_it_has_no_such_name(slides: bool, size: float, named: list[str]):
    listed = {key: effect for key, effect in catalogue().items() if key in KEYS}
    found = search_torque(sweep(size, 151.0, slides=slides), listed, starts=1, seed=0, tell=ignore_progress)
    assert [effect.key for effect in found.final.effects] == named
    if named:
        assert found.final.values["cogging_number"] == pytest.approx(151.0, abs=0.5)
        assert rms(found.final.unseen) < 0.6 * rms(fit_model(found.study).unseen)


@pytest.mark.long
def test_the_harmonics_of_a_ripple_are_one_name():
    listed = {key: effect for key, effect in catalogue().items() if key in KEYS}
    study = sweep(0.01, 9.0, (1.0, 0.6, 0.5))
    found = search_torque(study, listed, starts=1, seed=0, tell=ignore_progress)
    assert [effect.key for effect in found.final.effects] == ["cogging:harmonics"]
    values = found.final.values
    assert values["cogging_number"] == pytest.approx(9.0, abs=0.05)
    sizes = [np.hypot(values[f"cogging_sin_{h}"], values[f"cogging_cos_{h}"]) for h in (1, 2, 3)]
    assert sizes == pytest.approx([0.01, 0.006, 0.005], rel=0.1)


@pytest.mark.long
def test_teeth_and_poles_are_two_waves_under_one_name():
    listed = {key: catalogue()[key] for key in ("cogging", "cogging:second", "cubic_spring", "quadratic_drag")}
    study = sweep(0.01, 24.0)
    (run,) = study.runs  # from position to torque
    both = replace(study, runs=(run.but(y=run.y + 0.004 * np.sin(61.0 * run.u)),))
    found = search_torque(both, listed, starts=1, seed=0, tell=ignore_progress)
    assert [effect.key for effect in found.final.effects] == ["cogging", "cogging:second"]
    numbers = [found.final.values[id] for id in ("cogging_number", "second_cogging_number")]
    assert numbers == pytest.approx([24.0, 61.0], abs=0.2)
    alone = search_torque(study, listed, starts=1, seed=0, tell=ignore_progress)
    assert [effect.key for effect in alone.final.effects] == ["cogging"]


def test_a_family_is_no_entry_of_a_search_in_positions():
    families = [key for key, effect in catalogue().items() if effect.torque_only]
    assert families == ["cogging:second"]
    assert not set(families) & set(usable(catalogue(), law_named("lugre")))


def test_a_series_of_harmonics_stands_in_the_place_of_its_wave():
    series = {key: effect for key, effect in catalogue().items() if effect.series_of}
    assert list(series) == ["cogging:harmonics", "position_dependent_friction:harmonics"]
    for effect in series.values():
        wave = catalogue()[effect.series_of]
        own = {x.id for x in effect.parameters}
        assert wave.id == effect.id
        assert {x.id if x.id in own else f"{x.id}_1" for x in wave.parameters} <= own
