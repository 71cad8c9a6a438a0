"""A run whose sensor has another step or noise than in the joint's other runs is remarked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from haptid.measurement.remarks.between_runs import find_correlated_noise, find_odd_sensors
from haptid.measurement.signals.noise import with_noise
from haptid.measurement.values.run import Array, Run
from tests.measurement.remarks.test_suspicions import a_run, in_steps, moved

STEP = 7.7e-4


def cut_cell(y: Array, part: float = 0.2) -> Array:
    """Move the last reading to between two levels, as where a file was cut within a number."""
    y = y.copy()
    y[-1] += (part - 24) * STEP
    return y


def three_runs(change: Callable[[Array], Array], runs: int = 3) -> list[Run]:
    made = []
    for k in range(runs):
        t, u, y = moved(seed=k)
        y = change(in_steps(y, STEP)) if k == 1 else in_steps(y, STEP)
        made.append(with_noise(a_run(t, u, y, file=f"{k}.csv")))
    return made


@pytest.mark.parametrize("runs", [2, 3, 4])
@pytest.mark.parametrize("part", [0.2, 0.3, 0.413])
def test_a_cut_reading_is_told_with_its_time(runs: int, part: float):
    found = find_odd_sensors(three_runs(lambda y: cut_cell(y, part), runs))
    assert list(found) == [("1.csv", 0)]
    assert "other runs is 0.00077 (1 reading lies between those levels, first at 9.999 s)" in found["1.csv", 0]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda y: in_steps(y, STEP / 2), ""),
        (lambda y: y / 10, "the position: its step is 7.7e-05, that of the joint's other runs is 0.00077: was"),
        (lambda y: y + 0.02 * np.random.default_rng(7).standard_normal(y.size), "the position's noise is 0.02"),
        (lambda y: y + 2e-4 * np.random.default_rng(7).standard_normal(y.size), ""),
    ],
)
def test_other_steps_and_noise(change: Callable[[Array], Array], told: str):
    found = find_odd_sensors(three_runs(change))
    assert list(found) == ([("1.csv", 0)] if told else [])
    assert found.get(("1.csv", 0), "").startswith(told)


def test_excluded_runs_are_not_compared():
    runs = three_runs(cut_cell)
    runs[1] = runs[1].but(use="excluded")
    assert not find_odd_sensors(runs)


def repeated(noise: Callable[[np.random.Generator, int], Array], runs: int = 3) -> list[Run]:
    """Return runs of one torque and motion, each with noise of its own."""
    t = np.arange(0.0, 10.0, 1e-3)
    u, y = 0.01 * np.cos(3.0 * t), 0.3 * np.cos(3.0 * t - 0.5)
    rng = np.random.default_rng(5)
    return [with_noise(a_run(t, u, y + noise(rng, t.size), file=f"{k}.csv")) for k in range(runs)]


def coloured(rng: np.random.Generator, rows: int, kept: float = 0.8) -> Array:
    """Return noise of 2e-4 rad whose correlation falls by ``kept`` a row."""
    white, noise = rng.standard_normal(rows), np.zeros(rows)
    for k in range(1, rows):
        noise[k] = kept * noise[k - 1] + np.sqrt(1 - kept**2) * white[k]
    return 2e-4 * noise


def test_noise_that_is_correlated_is_told_by_the_spread_of_repeats():
    found = find_correlated_noise(repeated(coloured))
    assert list(found) == [("0.csv", 0)]
    sentence = found["0.csv", 0]
    assert sentence.startswith("the position differs by 0.0002 between 3 runs of the same torque, and white noise")
    assert sentence.endswith("state noise_rad = 0.0002 under [sensor]")


@pytest.mark.parametrize(
    "noise",
    [
        lambda rng, rows: 2e-4 * rng.standard_normal(rows),
        # A motion that does not repeat differs in long waves.
        lambda rng, rows: (
            2e-5 * rng.standard_normal(rows) + 1e-3 * rng.standard_normal() * np.sin(np.arange(rows) / 300)
        ),
    ],
)
def test_white_noise_and_a_motion_that_does_not_repeat_are_no_correlated_noise(noise):
    assert find_correlated_noise(repeated(noise)) == {}


def test_noise_that_is_stated_as_large_as_it_is_needs_no_remark():
    runs = [run.but(noise=np.array([2e-4])) for run in repeated(coloured)]
    assert find_correlated_noise(runs) == {}
    assert find_correlated_noise(runs[:1] * 2) == {}
