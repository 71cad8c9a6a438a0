"""An arm that is held between motions, with friction that turns at once: rests do not count, presliding gets stiff."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from haptid import Campaign
from haptid.discrepancy.torque.fit import fit_model, fit_nominal
from haptid.discrepancy.torque.study import TorqueStudy, torque_study_of
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.support.linear_algebra import rms

INERTIA, WEIGHT, COULOMB, VISCOUS = 0.02, 0.65, 0.08, 0.03
STEP_S = 2e-4
ROW = 25


def held_arm(targets: tuple[float, ...], seed: int) -> pd.DataFrame:
    """Simulate a PD-controlled arm with dry friction that sticks: each target is ramped to, and held."""
    rng, rows = np.random.default_rng(seed), []
    q = v = goal = 0.0
    for k in range(int(2.5 / STEP_S) * len(targets)):
        target = targets[int(k * STEP_S / 2.5)]
        goal += float(np.clip(target - goal, -1.2 * STEP_S, 1.2 * STEP_S))
        torque = 12.0 * (goal - q) - 0.3 * v
        moved = v + STEP_S / INERTIA * (torque - WEIGHT * np.sin(q) - VISCOUS * v)
        most = COULOMB * STEP_S / INERTIA
        v = 0.0 if abs(moved) <= most else moved - np.sign(moved) * most
        q += STEP_S * v
        if k % ROW == 0:
            rows.append((k * STEP_S, torque + 2e-3 * rng.standard_normal(), q + 2e-5 * rng.standard_normal(), goal))
    return pd.DataFrame(rows, columns=["time_s", "torque_0_Nm", "position_0_rad", "reference_0_rad"])


@pytest.fixture(scope="module")
def study() -> TorqueStudy:
    frames = {
        "a": held_arm((0.5, 1.2, 0.1, -0.8, 0.9), 1),
        "b": held_arm((-0.6, 0.3, 1.4, 0.4, -1.0), 2),
        "c": held_arm((0.8, -0.4, 0.7, 1.1, -0.2), 3),
    }
    campaign = Campaign.from_frames(frames, validate=["c"], measured=False)
    return torque_study_of(prepare_campaign(campaign.values), 0)


def test_a_torque_that_holds_a_resting_joint_does_not_count(study: TorqueStudy):
    for run, moving in zip(study.runs, study.moving, strict=True):
        assert 0.2 < moving.mean() < 0.7
        # The last half second of every target is a rest.
        held = (run.t + run.start_time) % 2.5 > 2.1
        assert moving[held].mean() < 0.1


def test_presliding_gets_as_stiff_as_the_torque_asks_for(study: TorqueStudy):
    # Coulomb friction would be reached after 5 mrad.
    soft = COULOMB / 5e-3
    narrow = replace(study, base=study.base.with_parameters({"sigma0": {"initial": soft / 2, "upper": soft}}))
    freed = fit_nominal(narrow, starts=1, seed=0)
    held = fit_model(replace(narrow, weight_of_turning=freed.study.weight_of_turning))
    assert held.values["sigma0"] == pytest.approx(soft, rel=1e-3)
    assert freed.values["sigma0"] > 3.0 * soft
    assert rms(freed.weighted) < 0.95 * rms(held.weighted)
    # At one speed throughout, viscous friction takes a part: less where rows near reversals do not weigh as all others.
    assert freed.values["Fc"] == pytest.approx(COULOMB, rel=0.05)
    alike = fit_model(replace(freed.study, weight_of_turning=1.0), start=freed.values)
    assert rms(alike.fitted) < 0.8 * rms(fit_model(narrow).fitted)
    assert alike.values["Fc"] < freed.values["Fc"]
    assert freed.study.base.parameter("sigma0").upper > soft


def test_friction_of_ramps_at_one_speed_is_guessed_by_the_plain_model(study: TorqueStudy):
    # A guess without it was a tenth of this, and stiction may be three times the guess at most.
    assert study.base.parameter("Fc").initial == pytest.approx(COULOMB, rel=0.2)
    assert study.base.parameter("Fs").upper > COULOMB


def test_a_stated_stiffness_keeps_its_range(study: TorqueStudy):
    soft = COULOMB / 5e-3
    narrow = study.base.with_parameters({"sigma0": {"initial": soft / 2, "upper": soft}})
    freed = fit_nominal(replace(study, base=narrow, stated=("sigma0",)), starts=1, seed=0)
    assert freed.values["sigma0"] <= soft * (1 + 1e-9)
