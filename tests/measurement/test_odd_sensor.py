"""A run whose sensor has another step or noise than in the joint's other runs is remarked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from haptid.measurement.checks.between_runs import find_odd_sensors
from haptid.measurement.signals.noise import with_noise
from haptid.measurement.values.run import Array, Run
from tests.measurement.test_suspicions import a_run, in_steps, moved

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
