"""Runs that no fit saw and that begin in motion: their bristles are deflected at the first row."""

from __future__ import annotations

import numpy as np
import pytest

from haptid import Campaign
from haptid.discrepancy.torque.first_states import first_states
from haptid.discrepancy.torque.fit import TorqueFit, fit_nominal
from haptid.discrepancy.torque.study import torque_study_of
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.support.linear_algebra import rms
from tests.discrepancy.torque.sticking_stage import COULOMB, fast_waves, recorded_stage

GAINS = {"P": 8000.0, "I": 60000.0, "D": 150.0}
BEGIN_ROWS = 30


@pytest.fixture(scope="module")
def found() -> TorqueFit:
    frames = {
        name: recorded_stage(fast_waves(seed), seed, 5.0, **GAINS) for name, seed in (("a", 1), ("b", 2), ("c", 3))
    }
    # Away from the stage's own start, in the middle of a stroke.
    for name, frame in frames.items():
        speed = frame["position_0_m"].diff().rolling(20).mean().abs()
        frames[name] = frame[speed[speed > 0.9 * speed.max()].index[0] :].reset_index(drop=True)
    campaign = Campaign.from_frames(frames, validate=["c"], measured=False)
    return fit_nominal(torque_study_of(prepare_campaign(campaign.values), 0), starts=1, seed=0)


def test_a_held_out_run_leaves_no_more_at_its_first_rows_than_later(found: TorqueFit) -> None:
    run, residual = found.study.runs[-1], found.residual[-1]
    assert run.use == "validate"
    assert rms(residual[:BEGIN_ROWS]) < 3.0 * found.left
    # The same run from undeflected bristles.
    spike = run.y[:, 0] - found.problem.simulator.simulate(found.theta, run).y[:, 0]
    assert rms(spike[:BEGIN_ROWS]) > 2.0 * max(found.left, rms(residual[:BEGIN_ROWS]))


def test_the_bristle_of_a_sliding_joint_holds_coulomb_friction(found: TorqueFit) -> None:
    run = found.study.runs[-1]
    (bristle,) = first_states(found.problem.simulator, found.theta, run)
    speed = run.extra["filtered_speed"][0]
    assert bristle * found.values["sigma0"] == pytest.approx(np.sign(speed) * COULOMB, rel=0.3)


def test_a_sealed_run_begins_as_a_held_out_one(found: TorqueFit) -> None:
    run = found.study.runs[-1]
    np.testing.assert_allclose(found.compute_missed(run), found.residual[-1], rtol=0.0, atol=1e-6 * rms(run.y))
