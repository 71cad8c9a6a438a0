"""Signatures to first order: the score is what a refit gains, where the base takes up nearly all of an effect too."""

from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from haptid.discrepancy.detect.score_tests import scan
from haptid.discrepancy.detect.signatures import effect_columns, signatures
from haptid.discrepancy.fit.nominal_fit import fit_nominal
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.study.coupled_study import coupled_study_of, place_in_joint
from haptid.discrepancy.study.study import Study, scales_over, study_of
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.effect import LAST, Effect, EffectState, parameter
from haptid.model.effects.registry import catalogue
from haptid.model.equations.equations import State
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import TRUTH
from tests.discrepancy.study.test_coupled import campaign

INPUTS = [Cosine(amplitude=a, frequency=w, duration=10.0, spacing=0.01) for a, w in ((0.008, 1.5), (0.012, 2.5))]


@pytest.mark.parametrize(
    ("key", "hidden"), [("asymmetric_spring", {"spring_quadratic": 2e-4}), ("cubic_spring", {"spring_cubic": 1e-3})]
)
def test_a_score_is_what_a_refit_gains(tmp_path: Path, key: str, hidden: dict[str, float]):
    truth = TRUTH | {"gravity_cos": 0.002, "gravity_sin": -0.001}
    make_joint_campaign(tmp_path, 3, truth, INPUTS, effects={key: hidden}, sensor=Sensor(noise=1e-4), seed=3)
    listed = {key: catalogue()[key]}
    study = study_of(read_campaign(tmp_path), 3, listed)
    base = fit_nominal(study, starts=4, seed=0).solution
    plain = solve(study, (), Noise(), base.values, x0=base.x0, iterations=200, tolerance=1e-6)
    effect = study.in_si(plain.values)[key]
    found = signatures(study, plain, [effect])
    (score,) = scan(study, plain, found, {key: effect}).scores
    again = solve(study, (effect,), Noise(), plain.values, x0=plain.x0, iterations=200, tolerance=1e-6)
    assert score.survives < 0.02
    gained = plain.chi2 - again.chi2
    assert abs(score.T - gained) < 0.25 * gained  # signatures run at a coarser step


def test_what_a_model_without_free_parameters_lacks_is_scored(tmp_path: Path):
    truth = TRUTH | {"gravity_cos": 0.0, "gravity_sin": 0.0}
    make_joint_campaign(
        tmp_path, 3, truth, INPUTS, effects={"cubic_spring": {"spring_cubic": 1e-3}}, sensor=Sensor(noise=1e-4), seed=3
    )
    fixed = {id: {"fixed": value} for id, value in truth.items()}
    study = study_of(read_campaign(tmp_path).but(parameter_overrides={3: fixed}), 3, {})
    solution = fit_nominal(study, starts=1, seed=0).solution
    effect = catalogue()["cubic_spring"].at(scales_over(study.fitted, solution.values, law_named(DEFAULT).roles))
    (score,) = scan(study, solution, signatures(study, solution, [effect]), {"cubic_spring": effect}).scores
    assert score.survives > 0.9  # only the initial states could take it up
    assert score.T > 1e3


def fading_torque(id: str, start: float, *, place: int = LAST) -> Effect:
    """Return a torque that fades within seconds of a run's start, by a state that does not start at zero."""
    amplitude, rest = sp.symbols(f"{id}_torque {id}_rest", real=True)
    state = State(id=f"{id}_rest", unit="1", description="what is left of it", start=start)
    return Effect(
        id=id,
        title=id,
        formula="A·x with T·ẋ = −x",
        lives_in="time",
        side="torque",
        parameters=(parameter(f"{id}_torque", "N m", "torque at the start", 1e-3, -1.0, 1.0),),
        torque=amplitude * rest,
        states=(EffectState(state=state, rhs=-rest / 2),),
        place=place,
    )


def one_joint(folder: Path) -> tuple[Study, Effect, Effect]:
    """Return a study, an effect of its model, and one that comes before it on the way of the torque."""
    make_joint_campaign(folder, 3, TRUTH, INPUTS[:1], sensor=Sensor(noise=1e-4), seed=3)
    return study_of(read_campaign(folder), 3, {}), fading_torque("known", 1.0), fading_torque("added", -1.0, place=1)


def two_joints(folder: Path) -> tuple[Study, Effect, Effect]:
    """Return a study, an effect of its model, and one in a joint with a smaller number."""
    known, added = place_in_joint(fading_torque("known", 1.0), 1), place_in_joint(fading_torque("added", -1.0), 0)
    return coupled_study_of(campaign(folder, {}), (0, 1), {}, {}), known, added


@pytest.mark.parametrize("case", [one_joint, two_joints])
def test_states_keep_their_values_where_those_of_a_new_effect_come_before_them(tmp_path: Path, case):
    study, known, added = case(tmp_path)
    values = {q.id: q.initial for q in study.base.parameters}
    solution = solve(study, (known,), Noise(), values, iterations=1)
    _, raw = effect_columns(study, solution, added)
    simulator = study.sketcher((known, added))
    last = [s.id for s in simulator.equations.states][-2:]
    assert last == [added.states[0].state.id, known.states[0].state.id]
    share = 0.03
    amplitude = added.parameters[0]
    expected = []
    for run, x0 in zip(study.fitted, solution.x0, strict=True):
        start = np.array([*x0[:-1], -1.0, x0[-1]])
        sets = [
            [(solution.values | {amplitude.id: a}).get(q.id, q.initial) for q in simulator.equations.parameters]
            for a in (0.0, share * amplitude.initial)
        ]
        y = simulator.simulate_many(np.array(sets), run, x0=start)
        expected.append(((y[1] - y[0]) / run.sensor_std / share).ravel())
    np.testing.assert_allclose(raw[:, 0], np.concatenate(expected), rtol=1e-9, atol=1e-9)  # of the noise
