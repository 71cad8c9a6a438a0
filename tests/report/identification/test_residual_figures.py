"""Autocorrelation, spectrum and amplitudes of cycles: known signals give known curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from haptid.identification.output.cycle_amplitudes import CycleAmplitudes, cycle_amplitudes
from haptid.identification.output.traces import Trace
from haptid.identification.result.fit import RunScore
from haptid.report.common.cycles import cycles_figure
from haptid.report.identification.figures import run_figure
from haptid.report.identification.residual_figures import autocorrelation_of, correlation_figure, spectrum_of
from tests.report.known import known_run
from tests.report.reading import told_in

STEP, ROWS = 0.01, 20_000
SCORE = RunScore(file="a.csv", use="fit", rmse=np.array([1e-3]), over_noise=1.0, nrmse=0.1, x0=np.zeros(1))


def trace(residual: np.ndarray) -> Trace:
    t = STEP * np.arange(residual.size)
    return Trace(
        score=SCORE, joints=(4,), t=t, measured=1e-3 * residual[:, None], simulated=np.zeros((residual.size, 1)),
        spread=np.zeros((residual.size, 1)), sigma=np.array([1e-3]), unit="rad", scored_from=0.0,
    )  # fmt: skip


def white(seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(ROWS)


def test_white_noise_has_no_correlation_and_the_spectrum_of_the_sensor():
    lag, correlation = autocorrelation_of(trace(white()))
    assert lag[0] == pytest.approx(STEP)
    assert np.mean(np.abs(correlation) < 1.96 / ROWS**0.5) == pytest.approx(0.95, abs=0.02)
    frequency, power = spectrum_of(trace(white()))
    assert frequency[-1] < 0.5 / STEP * 1.01
    assert power[frequency > 1.0].mean() == pytest.approx(1.0, abs=0.05)


def test_an_autoregressive_residual_shows_its_own_correlation():
    residual = lfilter([1.0], [1.0, -0.9], white())
    _, correlation = autocorrelation_of(trace(residual))
    assert correlation[:3] == pytest.approx([0.9, 0.81, 0.729], abs=0.02)
    frequency, power = spectrum_of(trace(residual))
    shown = frequency > 1.0
    expected = 1.0 / np.abs(1.0 - 0.9 * np.exp(-2j * np.pi * frequency[shown] * STEP)) ** 2
    assert np.mean(power[shown] / expected) == pytest.approx(1.0, abs=0.05)


def test_the_limits_of_white_noise_are_drawn():
    axis = correlation_figure([trace(white())]).axes[0]
    levels = sorted(float(line.get_ydata()[0]) for line in axis.lines[1:])
    assert levels == pytest.approx([-1.96 / ROWS**0.5, 1.96 / ROWS**0.5])


def test_residuals_of_one_label_have_one_unit_that_suits_the_largest():
    """40 N m stood on an axis as 40000 mN m."""
    small, large = trace(np.array([2.0, -3.0])), trace(np.array([2.0, -40e3]))
    for shown, label, factor in (([small], "residual [mrad]", 1e3), ([small, large], "residual [rad]", 1.0)):
        below = run_figure(shown).axes[-len(shown) :]
        assert below[0].get_ylabel() == label
        for axis, one in zip(below, shown, strict=True):
            assert axis.lines[0].get_ydata() == pytest.approx(factor * one.measured[:, 0])


def scattered(scatter: np.ndarray, noise: float = 1e-4) -> CycleAmplitudes | None:
    t = np.arange(0.0, 10.0, STEP)
    u, shape = np.cos(2 * np.pi * t), np.sin(2 * np.pi * t)
    factors = 1.0 + scatter[np.minimum(np.floor(t + 1e-9).astype(int), scatter.size - 1)]
    y = factors * shape + noise * np.random.default_rng(1).standard_normal(t.size)
    run = replace(known_run("a.csv"), t=t, u=u[:, None], y=y[:, None], noise=np.array([noise]))
    return cycle_amplitudes(run, shape)


def test_cycles_that_scatter_are_told_with_their_amplitudes():
    scatter = 0.02 * np.random.default_rng(2).standard_normal(10)
    found = scattered(scatter)
    assert found is not None
    assert found.excess == pytest.approx(scatter, abs=1e-4)
    assert found.p_value < 1e-12


def test_cycles_of_one_amplitude_do_not_scatter():
    found = scattered(np.full(10, 0.01))
    assert found is not None
    assert found.excess == pytest.approx(np.full(10, 0.01), abs=1e-4)
    assert found.p_value > 1e-3


def test_the_bars_of_cycles_are_95_percent_intervals():
    one = CycleAmplitudes(file="a.csv", use="fit", excess=np.array([0.01, -0.02]), std=np.array([0.001, 0.002]))
    axis = cycles_figure([one]).axes[0]
    (bars,) = axis.containers
    assert told_in(axis) == ["a.csv (fit), cycle 1: +1 ± 0.2 %", "a.csv (fit), cycle 2: -2 ± 0.39 %"]
    ends = [segment[:, 1].tolist() for segment in bars.lines[2][0].get_segments()]
    assert ends == [pytest.approx([0.804, 1.196]), pytest.approx([-2.392, -1.608])]
