"""The proposed run: its torque, its words, and what it is expected to tell."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study, study_of
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.discrepancy.verdict.next_experiment import Proposal, propose
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import TRUTH


def proposal(evidence: float, repeats: int = 1, end_frequency: float = 3.0) -> Proposal:
    return Proposal(
        amplitude=0.01,
        frequency=3.0,
        end_frequency=end_frequency,
        offset=0.002,
        duration=10.0,
        rows=1001,
        evidence=evidence,
        repeats=repeats,
    )


@pytest.mark.parametrize(
    ("evidence", "repeats"),
    [
        (THRESHOLDS.verdict.clear_evidence, 1),
        (THRESHOLDS.verdict.clear_evidence / 2, 2),
        (THRESHOLDS.verdict.clear_evidence / 8, THRESHOLDS.verdict.most_repeats),
        (1.0, THRESHOLDS.verdict.most_repeats + 1),
    ],
)
def test_a_run_says_how_often_it_is_made_and_whether_that_tells(evidence: float, repeats: int):
    made = proposal(evidence, repeats)
    assert made.separation == pytest.approx(np.sqrt(evidence / 1001))
    words = made.as_json()["run"]
    assert (f"{repeats} times" in words) == (1 < repeats <= THRESHOLDS.verdict.most_repeats)
    assert ("no run within these limits" in words) == (repeats > THRESHOLDS.verdict.most_repeats)
    assert made.as_json()["tells"] == made.tells == (repeats <= THRESHOLDS.verdict.most_repeats)


def test_a_sweep_runs_from_one_frequency_to_the_other():
    swept = proposal(1.0, end_frequency=30.0)
    t = np.linspace(0.0, 10.0, 100_001)
    phase = np.unwrap(np.arccos(np.clip((swept.torque(t) - 0.002) / 0.01, -1, 1)))
    speed = np.abs(np.gradient(phase, t))
    turning = np.abs(np.sin(phase)) > 0.3
    assert speed[turning][:9] == pytest.approx(3.0 * 10.0 ** (t[turning][:9] / 10.0), rel=0.01)
    assert speed[turning][-9:] == pytest.approx(3.0 * 10.0 ** (t[turning][-9:] / 10.0), rel=0.01)
    assert "swept from 3 to 30 rad/s" in swept.as_json()["run"]
    assert proposal(1.0).torque(t) == pytest.approx(0.002 + 0.01 * np.cos(3.0 * t))


def without_noise(study: Study, solution: Solution) -> Study:
    """Put the readings of a model in place of the measured ones."""
    simulator = study.factory(solution.equations)
    runs = [
        run.but(y=simulator.simulate(solution.theta, run, x0=x0).y)
        for run, x0 in zip(study.fitted, solution.x0, strict=True)
    ]
    return replace(study, fitted=tuple(runs))


@pytest.mark.parametrize(("noise", "repeats"), [(2e-4, 1), (6e-4, 4)])
def test_expected_evidence_is_what_a_refit_of_the_rival_to_the_new_runs_leaves(
    tmp_path: Path, noise: float, repeats: int
):
    inputs = [Cosine(amplitude=a, frequency=w, duration=8.0, spacing=0.01) for a, w in ((0.008, 1.5), (0.006, 2.5))]
    delay = {"time_delay": {"delay": 0.004}}
    known = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
    make_joint_campaign(tmp_path, 3, TRUTH, inputs, effects=delay, sensor=Sensor(noise=noise), known=known, seed=5)
    listed = catalogue()
    study = study_of(read_campaign(tmp_path), 3, listed)
    late, lag = (listed[key] for key in ("time_delay", "amplifier_lag:rest"))
    winner = solve(study, (late,), Noise(), TRUTH | {"delay_time": 0.004}, iterations=60, tolerance=1e-4)
    study = without_noise(study, winner)
    winner = solve(study, (late,), Noise(), winner.values, x0=winner.x0, iterations=60, tolerance=1e-8)
    start = TRUTH | winner.values | {"lag_time": 0.004}
    rival = solve(study, (lag,), Noise(), start, x0=winner.x0, iterations=60, tolerance=1e-8)

    proposal = propose(study, [winner], [rival])

    template = study.fitted[0]
    run = template.but(file="new", u=proposal.torque(template.t)[:, None])
    run = run.but(y=study.factory(winner.equations).simulate(winner.theta, run, x0=winner.x0[0]).y)

    def evidence(repeats: int) -> float:
        more = replace(study, fitted=(*study.fitted, *[run] * repeats))
        starts = (*rival.x0, *[rival.x0[0]] * repeats)
        again = solve(more, (lag,), Noise(), rival.values, x0=starts, iterations=60, tolerance=1e-8)
        return again.chi2 - rival.chi2

    assert proposal.repeats == repeats
    assert evidence(1) == pytest.approx(proposal.evidence, rel=0.1)
    assert evidence(repeats) > 0.9 * THRESHOLDS.verdict.clear_evidence
    assert repeats == 1 or evidence(repeats - 1) < 1.1 * THRESHOLDS.verdict.clear_evidence


def test_a_rival_counts_as_far_as_it_is_from_the_nearest_variant_of_the_winner(tmp_path: Path):
    """A run that tells the settled lag from a delay may not tell the one that was at rest from it."""
    inputs = [Cosine(amplitude=0.008, frequency=1.5, duration=8.0, spacing=0.02)]
    make_joint_campaign(tmp_path, 3, TRUTH, inputs, effects={"time_delay": {"delay": 0.004}}, sensor=Sensor(noise=2e-4))
    listed = catalogue()
    study = study_of(read_campaign(tmp_path), 3, listed)
    fits = {
        key: solve(study, (listed[key],), Noise(), TRUTH | {parameter: 0.004})
        for key, parameter in (
            ("amplifier_lag:rest", "lag_time"),
            ("amplifier_lag:settled", "settled_lag_time"),
            ("time_delay", "delay_time"),
        )
    }
    rest, settled, late = fits.values()
    either = propose(study, [rest, settled], [late])
    alone = [propose(study, [one], [late]) for one in (rest, settled)]
    assert either.evidence < max(one.evidence for one in alone)
    assert either.repeats >= max(one.repeats for one in alone)
    assert either.evidence == propose(study, [settled, rest], [late]).evidence
