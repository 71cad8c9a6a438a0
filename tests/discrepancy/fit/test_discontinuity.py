"""A jump between two torques that were sent: what is told of its place, and what other runs are predicted from it."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from haptid.discrepancy.candidate.refit import settle
from haptid.discrepancy.fit.discontinuity import around, places, torques
from haptid.discrepancy.fit.held_out import predict
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study, study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import INPUTS, TRUTH

HIDDEN = 1.3e-3
JUMP = catalogue()["amplifier_dead_band:jump"]


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Study, Solution]:
    """Return a joint behind an amplifier with a hard dead band, fitted with one."""
    folder: Path = tmp_path_factory.mktemp("jump") / "c"
    known = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
    hidden = {"amplifier_dead_band": {"dead_band": HIDDEN}}
    make_joint_campaign(folder, 3, TRUTH, INPUTS, effects=hidden, sensor=Sensor(noise=1e-4), known=known, seed=6)
    study = study_of(prepare(read_campaign(folder)), 3, {"amplifier_dead_band:jump": JUMP})
    own = {name: value for name, value in TRUTH.items() if name in {q.id for q in study.base.parameters}}
    scaled = JUMP.but(
        parameters=tuple(q.but(initial=1e-5) if q.id == "dead_band_least" else q for q in JUMP.parameters)
    )
    begun = solve(study, (scaled,), Noise(), own | {"dead_band": 1.2 * HIDDEN})
    return study, settle(study, begun.effects, begun).solution


def test_a_hard_jump_is_found_between_the_two_torques_around_it(fitted: tuple[Study, Solution]):
    study, solution = fitted
    low, high = around(HIDDEN, torques(study.fitted, JUMP))
    width = solution.values["dead_band_edge"] * HIDDEN
    assert low - width <= solution.values["dead_band"] <= high + width
    assert predict(study, solution).noise_alone


def test_other_runs_are_predicted_with_the_jump_wherever_fitted_torques_allow_it(fitted: tuple[Study, Solution]):
    study, solution = fitted
    ids = [q.id for q in solution.equations.parameters]
    low, high = around(solution.values["dead_band"], torques(study.fitted, JUMP))
    run = study.unseen[0]
    u = run.u.copy()
    u[100:103, 0] = np.linspace(low, high, 5)[1:-1]
    other = replace(run, u=u)
    found = places(solution, study.fitted, (other,))
    jumps = sorted(float(theta[ids.index("dead_band")]) for theta in found)
    assert np.array_equal(found[0], solution.theta)
    assert len(found) == 1 + sum(not a <= found[0][ids.index("dead_band")] <= b for a, b in _between(low, high, u))
    assert low <= jumps[0] < jumps[-1] <= high
    assert places(solution, study.fitted, study.fitted)[1:] == ()


def _between(low: float, high: float, u: np.ndarray) -> list[tuple[float, float]]:
    sent = np.unique(np.abs(u[:, 0]))
    ends = [low, *sent[(sent > low) & (sent < high)], high]
    return list(itertools.pairwise(ends))
