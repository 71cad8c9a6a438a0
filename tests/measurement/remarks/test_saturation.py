"""A torque that rests at its largest value is remarked; one that was meant to rest, or has coarse numbers, is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.measurement.remarks.remarks import remarks_of
from haptid.measurement.remarks.saturation import find_saturation
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.drive import Controller, Drive
from tests.measurement.remarks.test_suspicions import a_run

T = np.arange(0.0, 10.0, 2e-3)
SINE = np.sin(2.0 * T)
TWO = 0.7 * SINE + 0.5 * np.sin(7.3 * T)


def run_with(torque: Array) -> Run:
    return a_run(T, torque, 0.1 * np.cos(2.0 * T) + 1e-4 * np.random.default_rng(0).standard_normal(T.size))


def rounded(torque: Array, step: float) -> Array:
    return np.round(torque / step) * step


@pytest.mark.parametrize(
    ("torque", "ends"),
    [
        (np.clip(SINE, -0.8, 0.8), "highest and lowest"),
        (np.clip(TWO, -9.0, 0.9), "highest"),
        (np.clip(rounded(TWO, 0.01), -0.8, 0.8), "highest and lowest"),
        (np.clip(20 * SINE * (SINE > 0) + 3 * np.cos(9 * T), -5, 5), "highest"),
    ],
)
def test_a_clipped_torque_is_remarked_with_what_to_do(torque, ends):
    said = find_saturation(run_with(torque), 0)
    assert said.startswith(f"the torque rests at its {ends}")
    assert "what acted" in said


@pytest.mark.parametrize(
    "torque",
    [
        SINE,
        TWO,
        rounded(SINE, 0.02),  # 6 % of its rows are at its peaks
        rounded(TWO, 0.1),
        np.sign(SINE),
        np.sign(SINE) * (np.abs(SINE) > 0.5),
        np.where(SINE > 0.9, SINE, 0.0),
        rounded(TWO, 0.25),
        np.floor(T) - 4.0,
        np.repeat(np.random.default_rng(1).standard_normal(50), 100),
        np.full(T.size, 0.3),
    ],
    ids=[
        "sine",
        "two",
        "coarse",
        "coarser",
        "square",
        "three",
        "bursts",
        "coarsest",
        "staircase",
        "random",
        "constant",
    ],
)
def test_a_torque_that_was_meant_so_is_not_remarked(torque):
    assert not find_saturation(run_with(torque), 0)


def test_a_controlled_torque_that_is_hardly_anywhere_but_at_its_ends_is_remarked():
    limited = run_with(np.clip(200.0 * SINE, -1.0, 1.0))
    assert find_saturation(limited, 0) == ""  # a square wave by design
    reference = {f"reference_{limited.free_joints[0]}_rad": limited.y[:, 0]}
    assert "highest and lowest" in find_saturation(limited.but(extra=reference), 0)


def test_the_limit_of_a_stated_controller_is_known():
    runs = (run_with(np.clip(SINE, -0.8, 0.8)),)
    campaign = Campaign(folder=Path("made"), title="", device="single_joint", measured=True, runs=runs)
    (bare,) = remarks_of(campaign)
    assert any("rests at its highest" in sentence for sentence in bare.doubts[0])
    drive = Drive(kind="current", controller=Controller(kind="p", gain=1.0, limit=0.8))
    (stated,) = remarks_of(campaign.but(drives={0: drive}))
    assert not any("rests at its highest" in sentence for sentence in stated.doubts[0])


def test_a_stated_noise_far_below_the_stated_step_is_remarked():
    def remarks(noise: float) -> str:
        runs = (run_with(SINE).but(noise=np.array([noise]), resolution=np.array([1.5e-3])),)
        campaign = Campaign(folder=Path("made"), title="", device="single_joint", measured=True, runs=runs)
        return "; ".join(remarks_of(campaign)[0].by_joint[0])

    assert "the stated noise of 1e-06 is far below what the stated encoder step leaves, 0.00043" in remarks(1e-6)
    assert "far below" not in remarks(1e-4)
