"""Two effects at once, one of them found first: the other on top of it, as it was fitted or from the first guesses."""

from dataclasses import replace

import pytest

from haptid.discrepancy.candidate.candidate import score_candidate
from haptid.discrepancy.candidate.trial import Trial
from haptid.discrepancy.fit.homotopy import hold_shapes
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.search.trials.judging import judge_candidate
from haptid.discrepancy.search.trials.searcher import Searcher
from haptid.discrepancy.search.two_effects import (
    Way,
    add_second_effect,
    extend_by_best_scores,
    extend_from_first_guesses,
)
from haptid.discrepancy.study.study import study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.search.test_search import tools_of

KEYS = ("cogging", "cubic_spring", "encoder_ripple", "torque_bias_drift", "torque_ripple")
HIDDEN = {
    "torque_ripple": {"ripple": 0.041, "ripple_number": 9.0, "ripple_phase": 1.67},
    "torque_bias_drift": {"bias_rate": 1.2e-5},
}
TRUTH = {
    "inertia": 1.25e-4, "gravity_cos": -0.0015, "gravity_sin": -0.0008, "Kp": 1.0, "Ks": 0.04, "epos": -0.08,
    "sigma0": 1.03, "sigma1": 0.0033, "sigma2": 0.0023, "vs": 0.08, "Fs": 1.15e-3, "Fc": 8.5e-4,
}  # fmt: skip
KNOWN = {
    "gravity_cos": {"initial": 0.0, "lower": -0.005, "upper": 0.005},
    "gravity_sin": {"initial": 0.0, "lower": -0.005, "upper": 0.005},
    "inertia": {"initial": 1.2e-4}, "Ks": {"initial": 0.031}, "sigma0": {"initial": 0.83},
    "sigma1": {"initial": 0.0028}, "sigma2": {"initial": 0.0018}, "vs": {"initial": 0.067},
    "Fs": {"initial": 0.0013}, "Fc": {"initial": 0.0011},
}  # fmt: skip
INPUTS = tuple(
    Cosine(amplitude=0.008, frequency=w, use=use, duration=16.0, spacing=0.01)
    for w, use in ((0.5, "fit"), (1.0, "fit"), (1.5, "validate"), (2.0, "fit"), (2.5, "validate"))
)


@pytest.fixture(scope="module")
def lead(tmp_path_factory: pytest.TempPathFactory) -> tuple[Searcher, Trial, Solution]:
    """The search's tools, the base, and the base with one of two hidden effects."""
    folder, sensor = tmp_path_factory.mktemp("two") / "c", Sensor(noise=4e-4)
    make_joint_campaign(folder, 5, TRUTH, INPUTS, effects=HIDDEN, sensor=sensor, known=KNOWN, seed=5)
    study = study_of(prepare(read_campaign(folder)), 5, {key: catalogue()[key] for key in KEYS})
    s, start = tools_of(study, starts=2)
    drift = s.catalogue["torque_bias_drift"]
    values = start.solution.values | {q.id: q.initial for q in drift.parameters}
    return s, start, solve(study, (drift,), Noise(), values, x0=start.solution.x0)


def test_no_combination_is_begun_once_the_effort_is_spent(lead: tuple[Searcher, Trial, Solution]):
    s, start, first = lead
    told: list[tuple[str, str]] = []
    tired = replace(
        s, study=replace(s.study, effort=7), simulations=7, tell=lambda title, figures: told.append((title, figures))
    )
    assert add_second_effect(tired, [first], start, extend_by_best_scores) == []
    assert tired.cut
    assert told == [("no further combinations", "7 runs simulated")]
    assert not s.cut


@pytest.mark.long
@pytest.mark.parametrize("way", [extend_by_best_scores, extend_from_first_guesses])
def test_the_second_effect_is_found_on_top_of_the_first(lead: tuple[Searcher, Trial, Solution], way: Way):
    s, start, first = lead
    assert not judge_candidate(s, score_candidate(s.study, first, 0)).adequate
    good = [t for t in add_second_effect(s, [first], start, way) if t.adequate and t.acceptable]
    assert [set(t.solution.ids) for t in good] == [set(HIDDEN)]
    assert (frozenset(first.keys) in s.extended) == (way is extend_from_first_guesses)


def test_a_shape_is_held_half_a_step_of_its_grid_wide_and_an_amplitude_not_at_all():
    ripple = catalogue()["torque_ripple"]
    (_, grid), *_ = ripple.shapes
    values = {"ripple_sin": 0.02, "ripple_cos": 0.0, "ripple_number": grid[1]}
    priors = {q.id: q.prior for q in hold_shapes(ripple, values).parameters}
    assert priors["ripple_sin"] is None
    assert priors["ripple_number"].mean == grid[1]
    assert priors["ripple_number"].std == pytest.approx(min(grid[1] - grid[0], grid[2] - grid[1]) / 2)
    delay = catalogue()["time_delay"]
    assert all(q.prior is None for q in hold_shapes(delay, {q.id: q.initial for q in delay.parameters}).parameters)
