"""Stages that stick, and lack nothing: rows near a reversal or a rest name no effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from haptid import Campaign
from haptid.discrepancy.torque.fit import TorqueFit, fit_model, fit_nominal
from haptid.discrepancy.torque.study import TorqueStudy, torque_study_of
from haptid.discrepancy.torque_search.candidate import TorqueCandidate, compare_candidates
from haptid.discrepancy.torque_search.scan import promises
from haptid.discrepancy.torque_search.search import refit_candidate
from haptid.identification.simulators.inverse_dynamics import measured_motion
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.model.effects.registry import catalogue
from haptid.support.linear_algebra import rms
from tests.discrepancy.torque.sticking_stage import (
    COULOMB,
    MASS,
    VISCOUS,
    fast_waves,
    recorded_stage,
    slow_waves,
    steps,
)


def study_of(reference: Callable[[int], Callable[[float], float]], duration_s: float, **gains: float) -> TorqueStudy:
    frames = {
        name: recorded_stage(reference(seed), seed, duration_s, **gains)
        for name, seed in (("a", 1), ("b", 2), ("c", 3))
    }
    return torque_study_of(prepare_campaign(Campaign.from_frames(frames, validate=["c"], measured=False).values), 0)


@pytest.fixture(scope="module")
def held_stage() -> TorqueStudy:
    return study_of(steps, 8.0, P=2e4, I=2e5, D=400.0)


@pytest.fixture(scope="module")
def slow_stage() -> TorqueStudy:
    return study_of(slow_waves, 12.0, P=4e3, I=0.0, D=20.0)


def candidate(key: str, base: TorqueFit) -> TorqueCandidate:
    study = base.study
    best, *_ = promises(study, base, {key: catalogue()[key].at(study.scales(base.values))})
    model = refit_candidate(study, base, best)
    assert model is not None
    return compare_candidates(key, base, model)


def test_rows_near_a_reversal_or_a_rest_are_told_from_others(held_stage: TorqueStudy):
    for run, moving, turning in zip(held_stage.runs, held_stage.moving, held_stage.turning, strict=True):
        v = measured_motion(run)[:, 1]
        reversals = np.flatnonzero(np.diff(np.sign(v)) != 0)
        assert turning[reversals].all()
        # A joint at full speed is far from both.
        fast = np.abs(v) > 0.5 * np.abs(v).max()
        assert moving[fast].all()
        assert not turning[fast].any()
        assert 0.1 < (moving & ~turning).mean() < 0.6


def test_a_filter_that_mixes_rests_in_does_not_change_the_friction(held_stage: TorqueStudy):
    base = fit_nominal(held_stage, starts=1, seed=0)
    assert base.values["inertia"] == pytest.approx(MASS, rel=0.01)
    assert base.values["Fc"] == pytest.approx(COULOMB, rel=0.05)


def test_friction_that_turns_within_the_filter_is_no_lag(held_stage: TorqueStudy):
    base = fit_nominal(held_stage, starts=1, seed=0)
    assert not candidate("friction_lag", base).acceptable
    # Where every row names effects, and all weigh the same, the lag fits well enough to be named.
    base = fit_nominal(replace(held_stage, turning=()), starts=1, seed=0)
    lag = candidate("friction_lag", base)
    assert lag.bic > 10.0
    assert rms(lag.model.fitted) < rms(base.fitted)


@pytest.mark.long
@pytest.mark.parametrize("key", ["time_delay", "periodic_disturbance", "quadratic_drag"])
def test_a_stage_that_sticks_and_slips_lacks_nothing(slow_stage: TorqueStudy, key: str):
    assert not candidate(key, fit_nominal(slow_stage, starts=1, seed=0)).acceptable


def test_rows_near_reversals_do_not_bend_the_friction():
    study = study_of(fast_waves, 6.0, P=4e4, I=2e5, D=400.0)
    alike, weighted = fit_model(study), fit_nominal(study, starts=1, seed=0)
    assert weighted.study.weight_of_turning < 0.5
    assert weighted.left < alike.left
    for id, truth in (("Fc", COULOMB), ("sigma2", VISCOUS)):
        assert weighted.values[id] == pytest.approx(truth, rel=0.01)
        assert abs(alike.values[id] / truth - 1.0) > 0.05
