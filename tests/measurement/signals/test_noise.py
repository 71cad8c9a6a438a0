import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt, lfilter

from haptid.measurement.signals.noise import campaign_with_noise, contrasts, estimate_noise, with_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run

T = np.arange(2400) / 200.0


def run(t, y, **changes) -> Run:
    values = {
        "file": "a.csv", "free_joints": (4,), "t": t, "u": np.cos(t)[:, None], "y": y[:, None],
        "noise": [np.nan], "resolution": [np.nan], "posture": [], "use": "fit",
    }  # fmt: skip
    return Run(**{**values, **changes})


@pytest.mark.parametrize("omega", [0.5, 1.13, 7.0, 30.0, 60.0])
@pytest.mark.parametrize("seed", range(4))
def test_white_noise_on_smooth_motion_within_ten_percent(omega, seed):
    noise = 2e-4 * np.random.default_rng(seed).standard_normal(T.size)
    assert estimate_noise(T, 0.4 * np.sin(omega * T) + noise) == pytest.approx(2e-4, rel=0.1)


def test_noise_with_uneven_rows():
    rng = np.random.default_rng(1)
    t = np.cumsum(0.005 * (1 + 0.4 * rng.uniform(-1, 1, 2400)))
    y = 0.4 * np.sin(7 * t) + 3e-4 * rng.standard_normal(t.size)
    assert estimate_noise(t, y) == pytest.approx(3e-4, rel=0.1)


def test_noise_is_not_moved_by_gross_outliers_and_kinks():
    rng = np.random.default_rng(2)
    y = 0.1 * np.abs(np.sin(2 * T)) + 2e-4 * rng.standard_normal(T.size)
    y[rng.integers(0, T.size, 12)] += 0.5
    assert estimate_noise(T, y) == pytest.approx(2e-4, rel=0.15)


def test_encoder_step_is_not_counted_as_noise():
    rng = np.random.default_rng(3)
    step = 4e-4
    y = step * np.round((0.4 * np.sin(2 * T) + 2e-4 * rng.standard_normal(T.size)) / step)
    found = with_noise(run(T, y))
    assert found.resolution[0] == pytest.approx(step, rel=1e-9)
    assert found.noise[0] == pytest.approx(2e-4, rel=0.1)
    assert found.sensor_std[0] == pytest.approx(np.hypot(2e-4, step / np.sqrt(12)), rel=0.1)


SLOW = np.arange(8000) / 500.0


@pytest.mark.parametrize("seconds", [6.0, 16.0])
@pytest.mark.parametrize("omega", [0.5, 2.3, 3.7])
@pytest.mark.parametrize("edge_hz", [15.0, 25.0, 40.0])
@pytest.mark.parametrize("smooth", [lfilter, filtfilt])
def test_noise_behind_a_low_pass_filter_is_that_of_rows_farther_apart(smooth, edge_hz, omega, seconds):
    t = SLOW[seconds > SLOW]
    noise = smooth(*butter(2, edge_hz / 250.0), 2e-4 * np.random.default_rng(5).standard_normal(t.size))
    y = 0.5 * np.cos(omega * t) + noise
    assert 0.5 < estimate_noise(t, np.round(y, 9)) / noise.std() < 2.0


@pytest.mark.parametrize("pole", [0.0, 0.6, 0.9])
def test_correlated_noise_is_none_behind_a_filter(pole):
    noise = 2e-4 * lfilter([1.0], [1.0, -pole], np.random.default_rng(6).standard_normal(SLOW.size))
    noise += 1e-5 * np.random.default_rng(7).standard_normal(SLOW.size)
    estimate = estimate_noise(SLOW, 0.5 * np.cos(2.3 * SLOW) + noise)
    assert estimate == pytest.approx(2e-4 / (1.0 + pole), rel=0.15)  # what neighbouring rows differ by


@pytest.mark.parametrize("rows", [7, 8, 12, 13, 40])
def test_runs_too_short_to_show_a_filter_have_an_estimate(rows):
    noise = 2e-4 * np.random.default_rng(4).standard_normal(rows)
    assert 2e-5 < estimate_noise(T[:rows], 0.1 * np.cos(T[:rows]) + noise) < 2e-3


def test_noise_free_motion_leaves_a_floor_above_zero():
    assert 0 < estimate_noise(T, np.sin(T)) < 1e-8
    assert 0 < estimate_noise(T, np.sin(T) + 0.02 * np.sin(40 * T)) < 1e-5


@settings(max_examples=60, deadline=None)
@given(st.floats(1e-6, 1e-2), st.floats(0.2, 20.0), st.integers(0, 2**31))
def test_resolution_of_a_quantised_reading_is_exact(step, omega, seed):
    rng = np.random.default_rng(seed)
    offset = rng.uniform(-1, 1)
    levels = np.round((0.3 * np.sin(omega * T) + 1e-4 * rng.standard_normal(T.size)) / step)
    assert estimate_resolution(offset + step * levels) == pytest.approx(step, rel=1e-6)


def test_resolution_of_a_file_rounded_to_decimals():
    step = 25 / 65535
    y = np.round(step * np.round(np.sin(T) / step), 6)
    assert estimate_resolution(y) == pytest.approx(step, rel=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_continuous_readings_have_no_step(seed):
    y = np.sin(T) + 1e-4 * np.random.default_rng(seed).standard_normal(T.size)
    assert estimate_resolution(y) == 0
    assert estimate_resolution(np.ones(50)) == 0


@given(st.integers(3, 8), st.integers(0, 2**31))
def test_contrasts_remove_polynomials_and_keep_unit_variance(order, seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.5, 1.5, 30))
    polynomial = np.polynomial.Polynomial(rng.standard_normal(order))((t - 15) / 15)
    np.testing.assert_allclose(contrasts(t, polynomial, order), 0, atol=1e-12)
    response = np.stack([contrasts(t, unit, order) for unit in np.eye(30)], axis=1)
    response += contrasts(t, np.zeros(30), order)[:, None]
    np.testing.assert_allclose(np.sum(response**2, axis=1), 1.0, rtol=1e-9)


def test_given_values_are_kept():
    y = np.sin(T) + 1e-3 * np.random.default_rng(0).standard_normal(T.size)
    assert with_noise(run(T, y, noise=[5.0], resolution=[6.0])).noise.tolist() == [5.0]
    half = with_noise(run(T, y, noise=[5.0]))
    assert (half.noise.tolist(), half.resolution.tolist()) == ([5.0], [0.0])


def test_runs_of_a_joint_share_one_estimate():
    rng = np.random.default_rng(0)
    runs = [run(T, np.sin(T) + s * rng.standard_normal(T.size), file=f"{s}") for s in (1e-4, 2e-4, 9e-4)]
    runs.append(run(T, np.sin(T), file="given", noise=[1.0], resolution=[0.5]))
    campaign = Campaign(folder=None, title="", device="single_joint", measured=True, runs=tuple(runs))
    filled = campaign_with_noise(campaign).runs
    assert [r.noise[0] for r in filled[:3]] == [filled[1].noise[0]] * 3
    assert filled[0].noise[0] == pytest.approx(2e-4, rel=0.1)
    assert filled[3].noise.tolist() == [1.0]
