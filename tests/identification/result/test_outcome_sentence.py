"""The sentence of a lonely minimum points to what fits: units where motion is left, missing effects where little is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from haptid.identification.baseline.compared import compare
from haptid.identification.fit.multistart import fit
from haptid.identification.fit.plain_fit import plain_fit
from haptid.identification.output.summary import attention
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import RunScore
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.outcome_sentence import tell_outcome
from haptid.identification.sequence.result_json import step_json
from haptid.identification.sequence.step import Step
from haptid.identification.statistics.score import score_of
from tests.identification.bench_joint import equations, runs, simulator


def test_a_lonely_minimum_near_the_data_is_not_blamed_on_units():
    found = fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=1)).but(outcome=Outcome.LONELY)
    configuration = Configuration(free_joints=(4,), posture=(), runs=runs())
    step = Step(configuration=configuration, fit=found, torque_scored=False, compared=None)
    assert "haptid missing" in tell_outcome(step)
    assert "units" not in tell_outcome(step)
    assert step_json(step)["outcome_sentence"] == tell_outcome(step) in attention(step)
    applied = max(np.abs(run.u).max() for run in runs())
    assert step_json(step)["largest_torque_Nm"] == applied > 0
    far = found.but(runs=tuple(replace(one, rmse=300.0 * one.rmse) for one in found.runs))
    assert "columns and units are right" in tell_outcome(replace(step, fit=far))
    assert "columns and units are right" in tell_outcome(replace(step, torque_scored=True))


def test_structure_in_a_run_that_no_fit_saw_is_told_beside_a_residual_near_the_noise():
    """A residual of 1.12 times the noise with a visible pattern was told as the sensor's noise."""
    found = fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=1)).but(outcome=Outcome.CONVERGED)
    configuration = Configuration(free_joints=(4,), posture=(), runs=runs())
    step = Step(configuration=configuration, fit=found, torque_scored=False, compared=None)
    time = step_json(step)["runs"][0]["residual_correlation_rows"]
    assert time == found.runs[0].correlation_time > 0
    unseen = replace(found.runs[0], file="unseen.csv", use="validate", over_noise=1.12, rows=2500)

    def told(score: RunScore, outcome: Outcome = Outcome.CONVERGED) -> tuple[str, list[str]]:
        one = replace(step, fit=found.but(outcome=outcome, runs=(*found.runs, score)))
        return tell_outcome(one), attention(one)

    sentence, said = told(replace(unseen, correlation_time=7.0))
    assert "unseen.csv leaves 1.12 times the noise, and what is left is not white" in sentence
    assert "sensor's noise" not in sentence
    assert said[0] == sentence
    # White noise of another size, a residual at the noise, and files that do not hold the time.
    for other in (
        replace(unseen, correlation_time=1.03), replace(unseen, correlation_time=7.0, over_noise=1.04),
        replace(unseen, correlation_time=None),
    ):  # fmt: skip
        sentence, said = told(other)
        assert sentence == Outcome.CONVERGED.value
        assert sentence not in said
    assert "is not white: raise --starts" in told(replace(unseen, correlation_time=7.0), Outcome.SINGLE_START)[0]
    assert told(replace(unseen, correlation_time=7.0), Outcome.ABOVE_NOISE)[0] == Outcome.ABOVE_NOISE.value


@pytest.mark.parametrize(("pole", "is_correlated"), [(0.0, False), (0.5, True), (-0.5, False)])
def test_a_score_says_whether_its_residual_is_white(pole: float, is_correlated: bool):
    run, random = runs()[0], np.random.default_rng(3)
    r = lfilter([1.0], [1.0, -pole], random.standard_normal(run.y.shape), axis=0) * run.sensor_std
    made = score_of(run, r, np.zeros(1))
    assert made.rows == r.size
    assert made.is_correlated == is_correlated
    assert made.correlation_time == pytest.approx((1 + pole) / (1 - pole), rel=0.25)
    assert score_of(run, np.full_like(r, np.nan), np.zeros(1)).correlation_time is None


def test_the_plain_model_has_no_warnings_of_the_fit_that_it_replaces():
    found = fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=1))
    compared = compare(equations(), np.array(found.theta), runs(), None, ())
    said = "never faster than vs (1.6 of 14 rad/s)"
    made = plain_fit(simulator(), found.but(warnings=(said,)), compared, runs())
    configuration = Configuration(free_joints=(4,), posture=(), runs=runs())
    step = Step(configuration=configuration, fit=made, torque_scored=False, compared=compared)
    assert said not in " ".join(attention(step))
