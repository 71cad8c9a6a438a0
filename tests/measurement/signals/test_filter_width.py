"""The filter of torques: wide enough for what tells inertia from the rest, and no wider than the motion bears."""

from __future__ import annotations

import numpy as np
import pytest

from haptid.identification.baseline.baseline import Baseline, fit_baseline
from haptid.measurement.signals import filtered_motion
from haptid.measurement.signals.filtered_motion import common_width, filter_run, state_width
from haptid.measurement.values.run import Run

INERTIA, WEIGHT, STEP = 0.18, 3.5, 2.9e-3


def moved(rates: tuple[float, ...], sizes: tuple[float, ...], *, use: str = "fit") -> Run:
    """Return a pendulum along sines, its position rounded to an encoder's steps, with the torque that it needs."""
    t = np.arange(0.0, 6.0, 2e-3)
    waves = list(enumerate(zip(sizes, rates, strict=True)))
    q, v, a = (
        np.sum([A * w**order * np.sin(w * t + k + 0.5 * np.pi * order) for k, (A, w) in waves], axis=0)
        for order in range(3)
    )
    torque = INERTIA * a + WEIGHT * np.sin(q) + 0.15 * np.sign(v)
    return Run(
        file="swing.csv", free_joints=(0,), t=t, u=torque[:, None], y=STEP * np.round(q / STEP)[:, None],
        noise=[0.0], resolution=[STEP], posture=np.zeros(0), use=use, hold="linear",
    )  # fmt: skip


RESONANT = moved((4.3, 7.0), (0.8, 0.02))
"""Near √(weight/inertia) = 4.4 rad/s inertia and weight nearly cancel."""
APART = moved((1.5, 11.0), (0.3, 0.3))


def error_of_inertia(runs: list[Run]) -> float:
    found = fit_baseline(runs, None, (), [1.0])
    assert isinstance(found, Baseline)
    return abs(found.values["inertia"] / INERTIA - 1.0)


def test_near_resonance_the_filter_is_wider_and_the_inertia_right(monkeypatch: pytest.MonkeyPatch):
    runs = [RESONANT]
    assert common_width(runs) > 1.2 * state_width(runs)
    wide = error_of_inertia(runs)
    monkeypatch.setattr("haptid.identification.baseline.baseline.common_width", state_width)
    assert wide < 0.03
    assert error_of_inertia(runs) > 0.1


def test_where_inertia_stands_apart_the_filter_is_that_of_the_motion():
    assert common_width([APART]) == state_width([APART])


def test_runs_that_tell_inertia_together_need_no_wider_filter():
    together = [RESONANT, APART]
    assert common_width(together) < common_width([RESONANT])
    assert common_width(together) == state_width(together)


def test_an_unseen_run_widens_no_filter():
    unseen = RESONANT.but(use="validate")
    assert common_width([APART, unseen]) == state_width([APART, unseen])


def test_the_filter_leaves_the_motion():
    noisy = RESONANT.but(noise=np.array([0.1]))
    period = 2.0 * np.pi / 4.3
    assert common_width([noisy]) < 1.3 * filtered_motion.THRESHOLDS.largest_filter_width_over_period * period
    motion = filter_run(noisy, common_width([noisy]))
    assert np.std(motion.q[motion.interior]) > 0.94 * np.std(RESONANT.y[motion.interior])
