"""The sentence of a lonely minimum points to what fits: units where motion is left, missing effects where little is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from haptid.identification.baseline.compared import compare
from haptid.identification.fit.multistart import fit
from haptid.identification.fit.plain_fit import plain_fit
from haptid.identification.output.summary import attention
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.outcome import Outcome
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.outcome_sentence import tell_outcome
from haptid.identification.sequence.result_json import step_json
from haptid.identification.sequence.step import Step
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


def test_the_plain_model_has_no_warnings_of_the_fit_that_it_replaces():
    found = fit(simulator(), runs(), options=FitOptions(method="gauss_newton", starts=1))
    compared = compare(equations(), np.array(found.theta), runs(), None, ())
    said = "never faster than vs (1.6 of 14 rad/s)"
    made = plain_fit(simulator(), found.but(warnings=(said,)), compared, runs())
    configuration = Configuration(free_joints=(4,), posture=(), runs=runs())
    step = Step(configuration=configuration, fit=made, torque_scored=False, compared=compared)
    assert said not in " ".join(attention(step))
