"""Positions that a recorder averaged over rows: what is recognised, and what its noise is."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, cont2discrete, sosfiltfilt

from haptid.measurement.checks.summary import summarise, tell_table
from haptid.measurement.signals.averaging import average_rows, averaged_rows, with_averaging
from haptid.measurement.signals.control_detection import noise_link, position_control
from haptid.measurement.signals.noise import share_kept_of_average, with_noise
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run

T = np.arange(1600) * 0.01
STD = 2e-4


def run(y, t=T, **changes):
    return Run(
        file="a.csv", free_joints=(0,), t=t, u=np.zeros((t.size, 1)), y=y[:, None], noise=[np.nan], resolution=[0.0],
        posture=[], use="fit",
    ).but(**changes)  # fmt: skip


def readings(seed, colour=0.0):
    rng = np.random.default_rng(seed)
    slow = np.cumsum(rng.standard_normal(T.size)) * colour * STD
    motion = 0.4 * np.sin(5 * T) + 0.02 * np.abs(np.sin(2 * T))  # with impacts
    return motion + slow + STD * rng.standard_normal(T.size)


def test_an_average_is_that_of_pandas_but_for_the_ends():
    y = np.random.default_rng(0).standard_normal((40, 2)) + 1e6
    assert average_rows(y, 1) is y
    made = average_rows(y, 5)
    expected = pd.DataFrame(y).rolling(5, center=True).mean().to_numpy()
    np.testing.assert_allclose(made[2:-2], expected[2:-2], rtol=1e-13)
    assert made[0] == pytest.approx(y[0])
    assert made[1] == pytest.approx(y[:3].mean(axis=0))


@pytest.mark.parametrize("rows", [1, 3, 5, 7, 15])
@pytest.mark.parametrize("colour", [0.0, 0.3])
@pytest.mark.parametrize("step", [0.0, 1.5e-4])
def test_an_average_is_recognised_by_its_notches(rows: int, colour: float, step: float):
    made = [readings(seed, colour) for seed in range(3)]
    rounded = [step * np.round(y / step) if step else y for y in made]
    assert averaged_rows(tuple(run(average_rows(y, rows)) for y in rounded)) == rows


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_another_filter_is_no_average(share: float):
    through = butter(4, share, output="sos")
    assert averaged_rows(tuple(run(sosfiltfilt(through, readings(seed))) for seed in range(3))) == 1


def sprung(seed: int, rate: float) -> Run:
    """Swing a mass on a spring in open loop, by a held sum of cosines up to 3.1 Hz."""
    rng, t = np.random.default_rng(seed), np.arange(1200) / rate
    torque = sum(np.cos(2 * np.pi * f * t + p) for f, p in zip((0.4, 1.3, 3.1), rng.uniform(0, 6, 3), strict=True))
    plant = (np.array([[0.0, 1.0], [-140.0, -7.0]]), np.array([[0.0], [1.2]]), np.eye(2), np.zeros((2, 1)))
    A, B, *_ = cont2discrete(plant, 1 / rate)
    states = [np.zeros(2)]
    for u in torque[:-1]:
        states.append(A @ states[-1] + B[:, 0] * u)
    return run(np.array(states)[:, 0] + 5e-6 * rng.standard_normal(t.size), t, u=torque[:, None])


def test_a_motion_of_few_rows_a_period_is_neither_an_average_nor_control():
    made = tuple(sprung(seed, rate=20.0) for seed in range(3))
    assert averaged_rows(made) == 1
    assert [noise_link(one, 0) for one in made] == [0.0, 0.0, 0.0]
    assert [position_control(one) for one in made] == ["", "", ""]
    assert noise_link(sprung(0, rate=500.0), 0) < 0.1


def test_no_rows_no_average():
    assert averaged_rows(()) == 1
    assert averaged_rows((run(readings(0)[:100], T[:100]),)) == 1  # too few rows
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, T.size)) * 0.01
    assert averaged_rows((run(average_rows(readings(0), 5), uneven - uneven[0]),)) == 1
    assert averaged_rows((run(np.round(0.01 * T, 1)),)) == 1  # at rest within a step of the encoder


def test_a_stated_number_stays_and_the_others_share_one():
    y = average_rows(readings(0), 5)
    runs = (run(y), run(y, averaged_rows=3), run(average_rows(readings(1), 5)))
    campaign = Campaign(folder=None, title="", device="single_joint", measured=True, runs=runs)
    assert [r.averaged_rows for r in with_averaging(campaign).runs] == [5, 3, 5]


@pytest.mark.parametrize("rows", [3, 7])
def test_the_noise_is_that_of_the_averages(rows: int):
    found = with_noise(run(average_rows(readings(0), rows), averaged_rows=rows))
    assert found.noise[0] == pytest.approx(STD / np.sqrt(rows), rel=0.1)


@pytest.mark.parametrize("order", [3, 6])
@pytest.mark.parametrize("rows", [1, 3, 7])
def test_the_share_that_differences_show_is_that_of_white_noise(order: int, rows: int):
    white = np.random.default_rng(0).standard_normal(400_000)
    averages = np.convolve(white, np.ones(rows) / rows, mode="valid")
    seen = np.diff(averages, order).std() / np.diff(white, order).std()
    assert share_kept_of_average(order, rows) == pytest.approx(seen * np.sqrt(rows), rel=0.01)


def test_the_user_is_told_once():
    runs = tuple(
        run(average_rows(readings(k), 5)).but(file=f"{k}.csv", u=0.1 * np.cos(5 * T)[:, None], noise=[STD])
        for k in range(3)
    )
    campaign = Campaign(folder=None, title="", device="single_joint", measured=True, runs=runs)
    said = [line for line in tell_table(summarise(campaign)) if isinstance(line, str) and "averages" in line]
    assert said == ["  all 3 runs, joint 0: positions are averages over 5 rows: simulations are averaged alike"]
