"""Posterior of a joint under position control: its torque is compared, as in the fit of that torque."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from haptid.identification.first_guesses.initial_guess import guess
from haptid.identification.fit.fit_runs import JointTest
from haptid.identification.fit.own_bounds import FitEquations
from haptid.identification.problem.options import FitOptions
from haptid.identification.result.fit import Fit
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.simulators.inverse_dynamics import SPEED, torque_runs
from haptid.identification.workers.workers import Here
from haptid.measurement.values.campaign import Campaign
from haptid.measurement.values.run import Run
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.noise.noise_model import NoiseModel
from haptid.uq.result import subject as subject_module
from haptid.uq.result.infer import QUICK, InferOptions, infer
from haptid.uq.result.posterior import Posterior
from haptid.uq.result.subject import Subject, find_subject
from tests.identification.controlled_cases import controlled_joint, slow_sweep, truth_of
from tests.uq.uq_cases import TRUTH, make_equations, make_run

JOINT = 4


@pytest.fixture(scope="module")
def runs() -> tuple[Run, ...]:
    """Two slow sweeps under position control whose torque lacks a part that the model does not have."""
    return tuple(
        controlled_joint(JOINT, slow_sweep, seconds=16.0, seed=seed, use=use, extra=4e-3)
        for seed, use in ((1, "fit"), (2, "validate"))
    )


@pytest.fixture(scope="module")
def subject(runs: tuple[Run, ...], tmp_path_factory: pytest.TempPathFactory) -> Subject:
    equations = guess(joint_equations(JOINT), runs[:1], given={})
    campaign = Campaign(folder=Path("here"), title="sweeps", device="single_joint", measured=False, runs=runs)
    configuration = Configuration(free_joints=(JOINT,), posture=(), runs=runs)
    out = tmp_path_factory.mktemp("empty")
    return find_subject(campaign, None, configuration, equations, out, kind=None, seed=0, workers=Here())


@pytest.mark.long
def test_the_torque_is_the_residual_and_the_sampler_runs_the_equation_of_the_fit(
    subject: Subject, runs: tuple[Run, ...]
) -> None:
    assert subject.source == "made here"
    assert subject.fit.equations.joints == ()
    assert subject.fit.equations.outputs[0].unit == "N m"
    for turned, expected in zip(subject.runs, torque_runs(runs), strict=True):
        assert np.array_equal(turned.y, expected.y)
    assert subject.forward is not None
    thetas = subject.fit.theta * np.array([[1.0], [1.01], [0.98]])
    x0 = np.zeros(len(subject.fit.equations.states))
    together = subject.forward(thetas, subject.runs[0], x0)
    for theta, torque in zip(thetas, together, strict=True):
        assert np.abs(torque - subject.simulator.simulate(theta, subject.runs[0], x0=x0).y[:, 0]).max() < 1e-12


@pytest.fixture(scope="module")
def posterior(subject: Subject) -> Posterior:
    sampling = replace(QUICK, chunk=20, burn=30, longest=40)
    options = InferOptions(sampling=sampling, noise_given=False)
    return infer(
        subject.simulator, subject.runs, np.array(subject.fit.theta), options, joint=JOINT, forward=subject.forward
    )


@pytest.mark.long
def test_the_posterior_speaks_of_torques_and_holds_the_friction_that_moved_the_joint(
    posterior: Posterior, subject: Subject
) -> None:
    assert (posterior.residual, posterior.unit) == ("torque", "N m")
    by_id = {p.id: p for p in posterior.parameters}
    error = NoiseModel(correlated=True).hyper(noise_width=0.1, travel=1.0, unit=posterior.unit)[1]
    assert (error.id, error.unit) == ("model_error", "N m")
    assert posterior.next_run is None
    assert {s.model.scatter for s in posterior.candidates} == {"none"}
    # At one speed only the sum of Coulomb and viscous friction is known.
    speed = float(np.median(np.abs(subject.runs[0].extra[SPEED])))
    truth = truth_of(JOINT)
    found = by_id["Fc"].mean + by_id["sigma2"].mean * speed
    assert found == pytest.approx(truth["Fc"] + truth["sigma2"] * speed, rel=0.3)


def test_a_range_that_haptid_guessed_is_widened_before_the_sampler_begins(
    tmp_path: Path,
) -> None:
    """A fit on the end of a guessed range says something of the guess only, as in ``haptid identify``."""
    run = make_run(make_equations(), seed=1)
    equations = make_equations()
    ends = {"Ks": {"prior": None, "initial": 0.010, "lower": 0.005, "upper": 0.012}}
    campaign = Campaign(folder=Path("here"), title="cosine", device="single_joint", measured=False, runs=(run,))
    configuration = Configuration(free_joints=(4,), posture=(), runs=(run,))
    found = find_subject(
        campaign, None, configuration, equations.with_parameters(ends), tmp_path, kind=None, seed=0, workers=Here()
    )
    assert found.fit.values["Ks"] == pytest.approx(TRUTH["Ks"], rel=0.05)
    assert found.simulator.equations.parameter("Ks").upper > TRUTH["Ks"]


def test_other_starts_are_not_asked_at_an_inner_step_that_is_too_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in ``haptid identify``: they would compare the error of the step."""
    run = make_run(make_equations(), seed=1)
    campaign = Campaign(folder=Path("here"), title="cosine", device="single_joint", measured=False, runs=(run,))
    configuration = Configuration(free_joints=(4,), posture=(), runs=(run,))
    told: list[bool] = []

    def halve_step(test: JointTest, found: Fit, _: FitOptions) -> JointTest:
        return replace(test, equations=found.equations, step=test.step / 2)

    def fit_alone(
        fit: FitEquations, equations: Equations, *others: Any, needs_finer_step: Callable[[Fit], bool]
    ) -> Fit:
        found = fit(equations, others[-1])
        told.append(needs_finer_step(found))
        return found

    monkeypatch.setattr(subject_module, "at_needed_step", halve_step)
    monkeypatch.setattr(subject_module, "fit_within_own_bounds", fit_alone)
    found = find_subject(campaign, None, configuration, make_equations(), tmp_path, kind=None, seed=0, workers=Here())
    assert told == [True]
    assert found.share_of_steps == 0.5
