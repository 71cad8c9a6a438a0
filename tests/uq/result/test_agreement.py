"""A posterior that contradicts the fit it starts from says so."""

import numpy as np
import pytest

from haptid.identification.result.fit import Fit
from haptid.identification.result.outcome import Outcome
from haptid.uq.result.agreement import word_disagreement, word_misfit
from haptid.uq.result.arviz_door import Diagnostics
from haptid.uq.result.summary import ParameterSummary
from tests.uq.uq_cases import FREE, TRUTH, make_equations


def make_fit(statuses: dict[str, str] | None = None) -> Fit:
    equations = make_equations()
    std = [0.01 * abs(TRUTH[id]) for id in FREE]
    return Fit(
        equations=equations, theta=np.array([q.initial for q in equations.parameters]), free=FREE,
        covariance=np.diag(np.square(std)), information=np.eye(len(FREE)), cost=1.0, outcome=Outcome.CONVERGED,
        basins=(), starts=1, x0={}, sigma={}, correlation_time=1.0, simulations=1, wall_s=0.0,
        statuses=statuses or {},
    )  # fmt: skip


def make_summary(id: str, mean: float, std: float) -> ParameterSummary:
    diagnostics = Diagnostics(rhat=1.0, ess_bulk=1000.0, ess_tail=1000.0, mcse_mean=0.0)
    return ParameterSummary(
        id=id, unit="N m", description="", prior="", mean=mean, std=std, median=mean, intervals={}, contraction=0.1,
        overlap=0.1, diagnostics=diagnostics, verdict="",
    )  # fmt: skip


@pytest.mark.parametrize(("shift", "named"), [(3.0, False), (5.0, True)])
def test_distance_counts_in_standard_deviations_of_both(shift: float, named: bool):
    std = 0.01 * TRUTH["Fc"]
    told = word_disagreement(make_fit(), [make_summary("Fc", TRUTH["Fc"] + shift * std * np.sqrt(2.0), std)])
    assert ("Fc is" in told) is named


def test_what_the_fit_does_not_identify_cannot_contradict():
    far = [make_summary("Fc", 2.0 * TRUTH["Fc"], 1e-6), make_summary("vs", 1.0, 1e-6)]
    assert word_disagreement(make_fit({"Fc": "unidentifiable"}), far) == ""


@pytest.mark.parametrize(
    ("outcome", "told"), [(Outcome.CONVERGED, False), (Outcome.ABOVE_NOISE, True), (Outcome.TORQUE_SCORED, False)]
)
def test_a_posterior_of_a_model_that_does_not_fit_says_so(outcome: Outcome, told: bool):
    sentence = word_misfit(make_fit().but(outcome=outcome, cost=9.0))
    assert bool(sentence) == told
    assert ("leaves 3 times the noise" in sentence) == told


@pytest.mark.parametrize("outcome", [Outcome.UNEXPLAINED, Outcome.UNEXCITED])
def test_a_posterior_of_a_model_that_explains_nothing_means_nothing(outcome: Outcome):
    assert word_misfit(make_fit().but(outcome=outcome, cost=1e6)).startswith("No interval of this model means anything")
