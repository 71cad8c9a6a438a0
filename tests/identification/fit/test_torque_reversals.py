"""Fits of the torque of a stage that sticks: rests, reversals, and when the Stribeck curve needs no restraint."""

from __future__ import annotations

import numpy as np
import pytest

from haptid import Campaign
from haptid.identification.baseline.baseline import fit_baseline
from haptid.identification.fit.stribeck_restraint import (
    pays_for_release,
    release_stribeck,
    restrain_stribeck,
    restrained_ids,
)
from haptid.identification.fit.torque_fit import fit_torque
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.equations_for import equations_for
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_runs
from haptid.identification.simulators.slow_rows import at_rest, near_reversal, rests, turns
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from tests.discrepancy.torque import sticking_stage as stage

OPTIONS = FitOptions(starts=1, method="gauss_newton")
STRIBECK_SPEED = 0.03
"""Above 5 % of the top speed, where the restraint ends [m/s]."""
GAINS = {"P": 8000.0, "I": 60000.0, "D": 150.0}


def case(hidden: float) -> tuple[Equations, tuple[Run, ...]]:
    """Return equations and runs of the stage, with a hidden force of a sine over time [N] that no model has."""
    frames = {
        name: stage.recorded_stage(stage.fast_waves(seed), seed, 6.0, stribeck_speed=STRIBECK_SPEED, **GAINS)
        for name, seed in (("a", 1), ("b", 2), ("c", 3))
    }
    for frame in frames.values():
        frame["force_0_N"] += hidden * np.sin(2.3 * frame["time_s"])
    campaign = prepare_campaign(Campaign.from_frames(frames, validate=["c"], measured=False).values)
    return equations_for(campaign, None, (0,)), campaign.runs_of((0,))


def fitted(hidden: float) -> Fit:
    equations, runs = case(hidden)
    return fit_torque(equations, runs, own=[q.id for q in equations.parameters], options=OPTIONS)


@pytest.fixture(scope="module")
def right() -> Fit:
    return fitted(0.0)


def test_friction_is_not_bent_to_reversals(right: Fit) -> None:
    assert all(run.over_noise < 1.1 for run in right.runs)
    assert right.values["inertia"] == pytest.approx(stage.MASS, rel=0.005)
    assert right.values["Fc"] == pytest.approx(stage.COULOMB, rel=0.02)
    assert right.values["Fs"] == pytest.approx(stage.STICTION, rel=0.05)
    assert right.values["vs"] == pytest.approx(STRIBECK_SPEED, rel=0.1)
    assert right.values["sigma2"] == pytest.approx(stage.VISCOUS, rel=0.02)


def test_what_is_left_near_reversals_is_told(right: Fit) -> None:
    told = next(note for note in right.notes if "near reversals" in note)
    assert "they have the weight 0." in told
    # More than the noise is left there, else the rows would have the weight 1.
    left = float(told.split(" and leave ")[1].split(" N ")[0])
    assert left > 1.2 * max(run.rmse_rad for run in right.runs)


def test_a_curve_of_a_model_that_leaves_noise_is_not_restrained(right: Fit) -> None:
    assert restrained_ids(right.equations) == ()


def test_a_curve_of_a_model_that_lacks_something_is_restrained() -> None:
    found = fitted(1.0)
    assert max(run.over_noise for run in found.runs) > 2.0
    assert restrained_ids(found.equations) == ("vs", "Fs")
    assert found.values["vs"] <= found.equations.parameter("vs").upper * (1 + 1e-9)


def test_release_drops_the_priors_and_frees_the_speed_alone() -> None:
    equations, runs = case(0.0)
    held = restrain_stribeck(equations, runs, ())
    free = release_stribeck(held)
    assert restrained_ids(free) == ()
    assert free.parameter("vs").upper == pytest.approx(20.0 * held.parameter("vs").upper)
    assert free.parameter("vs").initial == held.parameter("vs").upper
    assert free.parameter("Fs").upper == held.parameter("Fs").upper
    assert restrained_ids(restrain_stribeck(equations, runs, ("vs", "Fs"))) == ()


@pytest.mark.parametrize(("gain", "pays"), [(0.0, False), (0.013, False), (0.014, True)])
def test_release_costs_what_the_information_criterion_asks(gain: float, pays: bool) -> None:
    # 2·ln 1000 = 13.8 of 1000 rows.
    assert pays_for_release(1.0 + gain, 1.0, 1000.0, 2, leaves_noise=True) is pays


@pytest.mark.parametrize(("left", "pays"), [(0.6, False), (0.4, True)])
def test_above_the_noise_the_restraint_has_to_be_what_most_came_from(left: float, pays: bool) -> None:
    assert pays_for_release(10.0, 10.0 * left, 1000.0, 2, leaves_noise=False) is pays


def test_the_weight_is_the_one_that_the_fit_asks_for(right: Fit) -> None:
    told = next(note for note in right.notes if "near reversals" in note)
    weight = float(told.split("the weight ")[1].split(" ")[0])
    near = float(told.split(" and leave ")[1].split(" N ")[0])
    away = np.sqrt(np.mean([run.rmse_rad**2 for run in right.runs if run.use == "fit"]))
    assert weight == pytest.approx(away / near, rel=0.1)


def test_stiction_beyond_the_guess_of_the_data_is_found() -> None:
    equations, runs = case(0.0)
    low = stage.STICTION / 6.0
    narrow = equations.with_parameters({"Fc": {"initial": low, "lower": low / 100.0, "upper": low * 100.0}})
    plain = fit_baseline(runs, None, [], [1.0])
    assert plain is not None
    own = [q.id for q in equations.parameters]
    found = fit_torque(narrow, runs, own=own, sliding=plain.of_joint("Fc", 0), options=OPTIONS)
    # Three times the guess from the data, the end of the restraint, is half of the stiction.
    assert found.values["Fs"] == pytest.approx(stage.STICTION, rel=0.05)


def test_a_rest_is_longer_than_a_reversal() -> None:
    t = np.arange(0.0, 4.0, 0.001)
    speed = np.where(t < 2.0, np.cos(2.0 * np.pi * t), 0.0)
    rest, turn = at_rest(speed, 5.0), near_reversal(speed, 5.0)
    assert not rest[:1900].any()
    assert rest[2000:].all()
    for reversal in (0.25, 0.75, 1.25, 1.75):
        assert turn[np.abs(t - reversal) < 0.008].all()
    assert not turn[np.abs(t - 1.0) < 0.2].any()


def test_rows_of_no_weight_take_no_part_and_others_have_a_wider_error() -> None:
    equations, runs = case(0.0)
    turned = torque_runs([run for run in runs if run.use == "fit"])
    simulator = TorqueSimulator.of(equations)
    weight = np.where(rests(turned[0]), 0.0, np.where(turns(turned[0]), 0.25, 1.0))
    weight[-300:] = 0.0
    theta = np.array([q.initial for q in equations.parameters])

    def rows(run: Run) -> np.ndarray:
        problem = Problem.of(simulator, (run,), OPTIONS)
        return problem.blocks(problem.unknowns_at(theta), jacobian=False).rows[0][:, 0]

    alike = rows(turned[0])
    np.testing.assert_allclose(rows(turned[0].but(weight=weight)), weight * alike, rtol=1e-12)
    both = (turned[0].but(weight=weight), turned[0])
    few, every = (Problem.of(simulator, (run,), OPTIONS).weight for run in both)
    assert few < every - 0.9 * 300


def test_a_weight_of_another_length_is_refused() -> None:
    _, runs = case(0.0)
    with pytest.raises(ValueError, match="weight needs one number a row, got 3 for"):
        runs[0].but(weight=np.ones(3))
