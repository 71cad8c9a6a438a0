"""Rivals whose time constants are shorter than the inner step, compared where that step does not make them alike."""

from pathlib import Path

import pytest

from haptid.discrepancy.detect.inner_step import at_step, visible
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.search.search import search
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import found, study_with

DELAY = 4.5e-4
QUIET = Sensor(noise=2e-5, resolution=0.0)


@pytest.mark.long
def test_a_lag_and_a_delay_below_the_step_are_compared_at_a_finer_one(tmp_path: Path):
    listed = {key: catalogue()[key] for key in ("amplifier_lag:rest", "time_delay")}
    study = study_with(tmp_path, {"time_delay": {"delay": DELAY}}, listed, QUIET)
    result = search(study, starts=2)
    assert result.study.factory.step < THRESHOLDS.study.coarse_step_s
    both = {t.solution.keys: t for t in (result.best, *result.trials)}
    lag, delay = both["amplifier_lag:rest",].solution, both["time_delay",].solution
    assert delay.values["delay_time"] == pytest.approx(DELAY, rel=0.05)
    assert lag.values["lag_time"] == pytest.approx(DELAY, rel=0.1)
    assert visible(result.study, lag, result.study.factory.step) < THRESHOLDS.detect.invisible_step_error_chi2
    coarse = solve(at_step(study, THRESHOLDS.study.coarse_step_s), lag.effects, Noise(), lag.values, x0=lag.x0)
    assert coarse.values["lag_time"] < 0.8 * DELAY
    assert set(result.less) == set(result.best.solution.keys)


def test_a_search_whose_step_is_fine_enough_ends_at_it(tmp_path: Path):
    finding = found(tmp_path, {"cubic_spring": {"spring_cubic": 0.02}})
    assert finding.search.study.factory.step == THRESHOLDS.study.coarse_step_s
