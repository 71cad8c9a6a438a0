"""Whether one set of parameters holds in every run: against fits of every run by itself."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from haptid.discrepancy.candidate.parameter_constancy import _test_runs, constancy
from haptid.discrepancy.fit.solution import Solution, solve
from haptid.discrepancy.study.study import Study, study_of
from haptid.discrepancy.thresholds.thresholds import THRESHOLDS
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.noise.correlation import Noise
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import TRUTH

EFFECTS = catalogue()
FREE = ("inertia", "Ks", "sigma2")
KNOWN = {id: {"fixed": value} for id, value in TRUTH.items() if id not in FREE}
TORQUES = ((0.008, 1.5, 0.004), (0.006, 2.5, 0.004), (0.007, 2.0, None))


def study_with(folder: Path, last: float, seed: int) -> Study:
    """Return a study with three runs of a joint whose delay [s] is ``last`` in the unseen third one."""
    runs = []
    for k, (amplitude, frequency, delay) in enumerate(TORQUES):
        cosine = Cosine(amplitude=amplitude, frequency=frequency, duration=8.0, spacing=0.01)
        hidden = {"time_delay": {"delay": last if delay is None else delay}}
        there, sensor = folder / f"{k}", Sensor(noise=2e-4)
        make_joint_campaign(there, 3, TRUTH, [cosine], effects=hidden, sensor=sensor, known=KNOWN, seed=10 * seed + k)
        runs.append(study_of(read_campaign(there), 3, EFFECTS))
    return replace(runs[0], fitted=(*runs[0].fitted, *runs[1].fitted), unseen=runs[2].fitted)


def fitted(study: Study) -> Solution:
    values = TRUTH | {"delay_time": 0.004}
    return solve(study, (EFFECTS["time_delay"],), Noise(), values, iterations=60, tolerance=1e-6)


def ratio(study: Study) -> float:
    """Return by how much ‖r‖² of all runs together exceeds the sum of every run's alone."""
    every = (*study.fitted, *study.unseen)
    apart = [fitted(replace(study, fitted=(run,), unseen=())).chi2 for run in every]
    return fitted(replace(study, fitted=every, unseen=())).chi2 - sum(apart)


@pytest.mark.parametrize("seed", [1, 2])
def test_it_is_the_likelihood_ratio_to_parameters_of_every_run(tmp_path: Path, seed: int):
    study = study_with(tmp_path, 0.004, seed)
    p, _, simulations = constancy(study, fitted(study))
    dof = (len(FREE) + 1) * (len(TORQUES) - 1)
    assert p > THRESHOLDS.candidate.lack_p_value
    assert np.log(p) == pytest.approx(chi2.logsf(ratio(study), dof), abs=0.1)
    assert simulations % len(TORQUES) == 0
    assert simulations > 0


def test_a_run_with_another_delay_is_told(tmp_path: Path):
    study = study_with(tmp_path, 0.005, 3)
    p, id, _ = constancy(study, fitted(study))
    assert p < THRESHOLDS.candidate.lack_p_value
    assert id == "delay_time"


def test_one_run_says_nothing(tmp_path: Path):
    study = study_with(tmp_path, 0.004, 1)
    alone = replace(study, fitted=study.fitted[:1], unseen=())
    assert constancy(alone, fitted(alone)) == (1.0, "", 0)


@pytest.mark.parametrize(("id", "told"), [("dead_band", False), ("Ks", True)])
def test_every_run_may_have_its_own_place_of_a_jump_but_no_other_parameter(tmp_path: Path, id: str, told: bool):
    """Beside torques that scatter, a row more or less lies beyond a dead band in every run: p was 2e-6."""
    hidden = {"amplifier_dead_band": {"dead_band": 6e-4}}
    cosines = [Cosine(amplitude=a, frequency=w, duration=8.0, spacing=0.01) for a, w, _ in TORQUES]
    make_joint_campaign(tmp_path, 3, TRUTH, cosines, effects=hidden, sensor=Sensor(noise=2e-4), known=KNOWN, seed=5)
    study = study_of(read_campaign(tmp_path), 3, EFFECTS)
    jump = study.in_si(TRUTH)["amplifier_dead_band:jump"]
    fit = solve(study, (jump,), Noise(), TRUTH | {"dead_band": 6e-4})

    def p_of(first: np.ndarray) -> float:
        rows = (noise[0] + first, *noise[1:])
        return _test_runs(replace(fit, blocks=replace(fit.blocks, rows=rows)))[0]

    noise = [np.random.default_rng(k).standard_normal(r.shape) for k, r in enumerate(fit.blocks.rows)]
    own = fit.blocks.jacobians[0][..., fit.problem.parametrisation.ids.index(id)]
    assert p_of(0.0 * own) > THRESHOLDS.candidate.lack_p_value
    assert (p_of(20.0 * own / np.linalg.norm(own)) < THRESHOLDS.candidate.lack_p_value) == told
