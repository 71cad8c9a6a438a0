"""Signatures to first order: the score is what a refit gains, where the base takes up nearly all of an effect too."""

from pathlib import Path

import pytest

from haptid.discrepancy.detect.score_tests import scan
from haptid.discrepancy.detect.signatures import signatures
from haptid.discrepancy.fit.nominal_fit import fit_base
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.study.study import scales_over, study_of
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.model.friction.registry import DEFAULT, law_named
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import TRUTH

INPUTS = [Cosine(amplitude=a, frequency=w, duration=10.0, spacing=0.01) for a, w in ((0.008, 1.5), (0.012, 2.5))]


@pytest.mark.parametrize(
    ("key", "hidden"), [("asymmetric_spring", {"spring_quadratic": 2e-4}), ("cubic_spring", {"spring_cubic": 1e-3})]
)
def test_a_score_is_what_a_refit_gains(tmp_path: Path, key: str, hidden: dict[str, float]):
    truth = TRUTH | {"gravity_cos": 0.002, "gravity_sin": -0.001}
    make_joint_campaign(tmp_path, 3, truth, INPUTS, effects={key: hidden}, sensor=Sensor(noise=1e-4), seed=3)
    entries = {key: catalogue()[key]}
    study = study_of(read_campaign(tmp_path), 3, entries)
    base = fit_base(study, starts=4, seed=0).solution
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
    solution = fit_base(study, starts=1, seed=0).solution
    effect = catalogue()["cubic_spring"].at(scales_over(study.fitted, solution.values, law_named(DEFAULT).roles))
    (score,) = scan(study, solution, signatures(study, solution, [effect]), {"cubic_spring": effect}).scores
    assert score.survives > 0.9  # only the initial states could take it up
    assert score.T > 1e3
