"""Ripple of gear teeth and poles: waves over position that no grid of the catalogue holds."""

import numpy as np
import pytest

from haptid.discrepancy.torque.fit import fit_model, rms
from haptid.discrepancy.torque.ripple import find_waves
from haptid.discrepancy.torque.search import search_torque
from haptid.model.effects.registry import catalogue
from tests.discrepancy.torque.test_torque import sweep

KEYS = ("cogging", "cubic_spring", "position_dependent_friction:wave", "quadratic_drag")


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


def test_gear_ripple_is_named_and_a_sweep_without_it_has_no_such_name():
    entries = {key: effect for key, effect in catalogue().items() if key in KEYS}
    for size, named in ((0.01, ["cogging"]), (0.0, [])):
        found = search_torque(sweep(size, 151.0), entries, starts=1, seed=0, tell=lambda _: None)
        assert [effect.key for effect in found.final.effects] == named
        if named:
            assert found.final.values["cogging_number"] == pytest.approx(151.0, abs=0.5)
            assert rms(found.final.unseen) < 0.6 * rms(fit_model(found.study).unseen)
