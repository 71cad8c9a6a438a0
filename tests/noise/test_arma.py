"""The correlation of the noise, and how well its power at low frequency is known."""

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from haptid.discrepancy.detect.chi_squared import log_tail
from haptid.measurement.values.run import Run
from haptid.noise.arma import _fit_periodograms, _freedom, estimate_arma, to_arma
from haptid.noise.correlation import Arma
from haptid.noise.thresholds import THRESHOLDS

T = np.arange(1601) * 0.01
OMEGAS = (0.6, 1.1, 1.7, 2.2)
PHI, STD = 0.9, 2e-4
ANGLES = np.linspace(0.01, 0.2, 20)  # up to 20 rad/s


def noisy(rng: np.random.Generator, coloured: float, size: float = 1.0, rhythm: float = 0.0, averaged: int = 1) -> Arma:
    runs, rows = [], []
    for k, omega in enumerate(OMEGAS):
        start = rng.standard_normal() * PHI
        shocks = np.sqrt(1 - PHI**2) * rng.standard_normal(T.size)
        r = rng.standard_normal(T.size) + coloured * lfilter([1.0], [1.0, -PHI], shocks, zi=[start])[0]
        r += rhythm * np.sin(3.88 * T)
        r = np.sqrt(averaged) * uniform_filter1d(r, averaged)  # the white part keeps its size
        y = 0.4 * np.cos(omega * T) + STD * r
        runs.append(
            Run(
                file=f"{k}", free_joints=(0,), t=T, u=np.cos(omega * T)[:, None], y=y[:, None], noise=np.array([STD]),
                resolution=np.zeros(1), posture=np.zeros(1), use="fit",
            )
        )  # fmt: skip
        rows.append(size * r)
    return estimate_arma(rows, tuple(runs))


@pytest.mark.long
def test_power_at_low_frequency_scatters_as_its_degrees_of_freedom_say():
    true = 1.0 + (1 + PHI) / (1 - PHI)
    found = [noisy(np.random.default_rng(seed), 1.0) for seed in range(12)]
    z = [(np.log(c.low_frequency_gain**2) - np.log(true)) / np.sqrt(2 / c.freedom) for c in found]
    assert all(20 < c.freedom < 300 for c in found)
    assert 0.5 < np.std(z) < 1.6
    assert abs(np.mean(z)) < 1.0


def test_white_noise_is_called_white_and_known():
    arma = noisy(np.random.default_rng(3), 0.0)
    assert arma.white
    assert arma.freedom == np.inf


@pytest.mark.parametrize("averaged", [3, 5, 7])
@pytest.mark.parametrize("coloured", [0.0, 1.0, 2.0])
def test_smoothed_readings_do_not_hide_the_noise_where_the_motion_is(averaged: int, coloured: float):
    arma = noisy(np.random.default_rng(8), coloured, averaged=averaged)
    power = averaged * (1.0 + coloured**2 * (1 - PHI**2) / np.abs(1 - PHI * np.exp(-1j * ANGLES)) ** 2)
    ratio = arma.gain(ANGLES) ** 2 / power
    assert 1 / 3 < ratio.min() < ratio.max() < 3.0  # AR(1) falls more slowly than a moving average


def ar1(angle: np.ndarray, variance: float, phi: float) -> np.ndarray:
    return variance * (1 - phi**2) / np.abs(1 - phi * np.exp(-1j * angle)) ** 2


@pytest.mark.parametrize(("white", "slower", "pole"), [(0.1, 1.0, 0.98), (0.15, 5.0, 0.99), (0.15, 0.0, 0.98)])
def test_a_stated_noise_that_is_mostly_slow_leaves_its_white_part_as_it_is(white: float, slower: float, pole: float):
    """The white part alone was taken for a band that a filter had emptied.

    What a model lacks is slower still and falls more steeply, so that the lines below that band do: the power above was
    estimated at a third of what it is, or a sixth.
    """
    angle = np.linspace(0.001, 3.14, 4000)
    spectrum = white + ar1(angle, 0.5, 0.9) + ar1(angle, slower, pole) ** 2
    power = spectrum * np.random.default_rng(8).exponential(size=angle.size)
    arma = _fit_periodograms([(angle, power, np.ones(angle.size))], 0.005)
    ratio = (arma.gain(angle) ** 2 / spectrum)[angle > 1.5]
    assert 0.7 < ratio.min() < ratio.max() < 1.4


@pytest.mark.parametrize(("coloured", "rhythm"), [(0.0, 0.9), (1.0, 2.5)])
def test_a_rhythm_between_the_harmonics_is_no_noise(coloured: float, rhythm: float):
    without, beside = (noisy(np.random.default_rng(5), coloured, rhythm=a) for a in (0.0, rhythm))
    assert beside.white == without.white
    assert abs(np.log(beside.low_frequency_gain / without.low_frequency_gain)) < 0.15


def test_a_residual_of_outliers_alone_is_no_noise():
    arma = noisy(np.random.default_rng(3), 0.0, size=1e3)
    assert arma == Arma()


def test_a_power_that_is_estimated_makes_the_tail_heavier():
    assert log_tail(460.0, 356, 100.0) > log_tail(460.0, 356) + 3
    assert abs(log_tail(460.0, 356, 1e7) - log_tail(460.0, 356)) < 1e-3


@pytest.mark.parametrize("scale", [0.0, 20.0, 2e5])
def test_a_likelihood_with_a_ridge_tells_as_little_as_can_be(scale: float):
    across = scale * np.array([[2.0, 1.0, 0.0], [-2.0, -1.0, -3.0]])
    assert _freedom(np.zeros(3), lambda p: float(((across @ p) ** 2).sum())) == THRESHOLDS.least_freedom_of_spectrum


def test_white_and_correlated_part_become_one_process_of_the_same_spectrum():
    angle = np.linspace(0.05, 3.1, 50)
    for white, coloured in ((1.0, 0.5), (1e-9, 1.0), (1.0, 1e12)):
        c = to_arma(np.array([np.log(white), np.log(coloured), 2.0]))
        phi = 1 / (1 + np.exp(-2.0))
        parts = white + coloured * (1 - phi**2) / np.abs(1 - phi * np.exp(-1j * angle)) ** 2
        whole = (
            c.sigma**2 * np.abs(1 - c.theta * np.exp(-1j * angle)) ** 2 / np.abs(1 - c.phi * np.exp(-1j * angle)) ** 2
        )
        np.testing.assert_allclose(whole, parts, rtol=1e-6)
