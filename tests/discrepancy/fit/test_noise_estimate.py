"""The noise that a fit leaves: scatter about the joint's place of rest, and when two noises are alike."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from haptid.discrepancy.candidate.refit import alike
from haptid.discrepancy.fit.noise_estimate import estimate
from haptid.discrepancy.fit.solution import solve
from haptid.discrepancy.study.study import study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.cycles import whole_cycles
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Arma, Noise, Scatter
from haptid.virtual_device.machine.joint import JOINT
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine, rich
from haptid.virtual_device.recording.sensor import Sensor

TRUTH = {
    "inertia": 1.6e-4, "gravity_cos": 0.0, "gravity_sin": 0.0, "Kp": 1.0, "Ks": 0.018, "epos": 0.12, "sigma0": 0.5,
    "sigma1": 0.003, "sigma2": 1.3e-3, "vs": 0.06, "Fs": 1.5e-3, "Fc": 1.1e-3,
}  # fmt: skip
SENSOR = Sensor(noise=2e-4, resolution=0.0)
INPUTS = tuple(Cosine(amplitude=a, frequency=w, duration=16.0, spacing=0.01) for a, w in ((0.008, 2.5), (0.006, 4.1)))


def estimated(folder: Path, scatter: float) -> Noise:
    known = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
    effects = {"amplitude_scatter": {"scatter": scatter, "scatter_on_torque": 0.0}}
    make_joint_campaign(folder, 3, TRUTH, INPUTS, effects=effects, sensor=SENSOR, known=known, seed=2)
    study = study_of(prepare(read_campaign(folder)), 3, catalogue())
    return estimate(study, solve(study, (), Noise(), TRUTH))


def test_the_reading_scatters_about_the_place_of_rest(tmp_path: Path):
    noise = estimated(tmp_path, 0.02)
    (found,) = noise.scatters
    assert found.path == "reading"
    assert found.size == pytest.approx(0.02, rel=0.5)  # 17 cycles
    assert found.centre == pytest.approx(TRUTH["epos"], abs=0.003)


def test_the_place_of_rest_is_found_beside_gravity_and_eight_runs(tmp_path: Path):
    truth = TRUTH | {"gravity_cos": -9e-4, "gravity_sin": -8e-4, "Ks": 0.033, "epos": -0.047}
    effects = {"amplitude_scatter": {"scatter": 0.02, "scatter_on_torque": 0.0}}
    make_joint_campaign(tmp_path, 5, truth, rich(5), effects=effects, sensor=SENSOR, seed=31)
    study = study_of(prepare(read_campaign(tmp_path)), 5, catalogue())
    rest = JOINT.rest_position(truth)
    begun = Noise(scatters=(Scatter(size=0.02, centre=rest),))
    noise = estimate(study, solve(study, (), begun, truth))
    assert noise.scatters[0].centre == pytest.approx(rest, abs=2e-3)
    assert noise.arma == Arma()


def test_a_fit_beside_a_scatter_of_the_torque_does_not_stop_at_a_common_factor(tmp_path: Path):
    known = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
    effects = {"amplitude_scatter": {"scatter": 0.02, "scatter_on_torque": 1.0}}
    make_joint_campaign(tmp_path, 3, TRUTH, INPUTS, effects=effects, sensor=SENSOR, known=known, seed=2)
    study = study_of(prepare(read_campaign(tmp_path)), 3, catalogue())
    noise = Noise(scatters=(Scatter(size=0.02, path="torque"),))
    driven = ("inertia", "Ks", "sigma0", "sigma1", "sigma2", "Fs", "Fc")
    off = TRUTH | {name: 0.93 * TRUTH[name] for name in driven}
    right, found = solve(study, (), noise, TRUTH), solve(study, (), noise, off)
    assert found.log_likelihood == pytest.approx(right.log_likelihood, abs=1.0)
    assert found.values["inertia"] == pytest.approx(right.values["inertia"], rel=2e-3)


def test_an_amplitude_that_drifts_over_a_run_is_no_scatter(tmp_path: Path):
    """A motion that settles, or a spring that grows warm, changes the amplitude with every cycle, not by chance."""
    known = {"gravity_cos": {"fixed": 0.0}, "gravity_sin": {"fixed": 0.0}}
    make_joint_campaign(tmp_path, 3, TRUTH, INPUTS, sensor=SENSOR, known=known, seed=2)
    campaign = read_campaign(tmp_path)
    rest = JOINT.rest_position(TRUTH)

    def drifting(run: Run) -> Run:
        growth = 0.02 * (whole_cycles(run).index - 3.0)
        return run.but(y=rest + (run.y - rest) * (1.0 + growth[:, None]))

    drifted = replace(campaign, runs=tuple(map(drifting, campaign.runs)))
    study = study_of(prepare(drifted), 3, catalogue())
    assert estimate(study, solve(study, (), Noise(), TRUTH)).scatters == ()


def test_white_noise_has_neither_scatter_nor_colour(tmp_path: Path):
    assert estimated(tmp_path, 0.0) == Noise()


def test_noises_are_alike_where_no_fit_could_tell():
    std = np.array([2e-4, 2e-4])
    plain = Scatter(size=0.02, centre=0.1)
    one = Noise(scatters=(plain,))
    assert alike(one, one.but(scatters=(plain.but(centre=0.1005),)), std)
    for other in (plain.but(centre=0.13), plain.but(path="torque"), plain.but(column=1), plain.but(size=0.03)):
        assert not alike(one, one.but(scatters=(other,)), std)
    assert not alike(one, one.but(scatters=()), std)
    assert not alike(one, one.but(scatters=(plain, plain.but(column=1))), std)
    assert not alike(one, one.but(arma=Arma(phi=0.9, theta=0.5, sigma=1.0)), std)
    assert alike(Noise(), Noise(), std)
