"""The search in the torque has the delay behind it that the plain model finds, and tells it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.torque.fit import fit_model
from haptid.discrepancy.torque.study import TorqueStudy, torque_study_of
from haptid.identification.simulators.inverse_dynamics import torque_runs
from haptid.measurement.checks.preparation import campaign_for_command
from haptid.support.linear_algebra import rms
from tests.identification.plain_joint import plain_run, torque_at

DELAY = 6e-3


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> TorqueStudy:
    folder, entries = tmp_path_factory.mktemp("late"), ""
    for seed, use in ((5, "fit"), (6, "fit"), (7, "validate")):
        run = plain_run(seed)
        early = np.array([torque_at(t + DELAY, seed) for t in run.t])
        early += 0.01 * np.random.default_rng(seed).standard_normal(run.t.size)
        table = np.column_stack((run.t, early, run.y[:, 0]))
        np.savetxt(folder / run.file, table, delimiter=",", header="time_s,torque_0_Nm,position_0_rad", comments="")
        entries += f'[[runs]]\nfile = "{run.file}"\nfree_joints = [0]\nuse = "{use}"\n'
    head = '[campaign]\ndevice = "single_joint"\nmeasured = false\nhold = "linear"\n[sensor]\nnoise_rad = 1e-4\n'
    Path(folder / "campaign.toml").write_text(f"{head}resolution_rad = 0.0\n{entries}", encoding="utf-8")
    return torque_study_of(campaign_for_command(folder), 0)


def test_the_study_has_the_delay_behind_it(study: TorqueStudy):
    assert study.delay == pytest.approx(DELAY, rel=0.1)
    prompt = replace(study, runs=torque_runs([run.but(score_from=0) for run in study.recorded]), delay=0.0)
    with_it, without = (rms(fit_model(one).unseen) for one in (study, prompt))
    assert with_it < 0.95 * without


@pytest.mark.parametrize(
    ("delay", "told"),
    [(6e-3, " The torque acts 6 ms after it is recorded, which no name stands for."), (0.0, "")],
)
def test_the_delay_is_told(study: TorqueStudy, delay: float, told: str):
    finding = SimpleNamespace(search=SimpleNamespace(study=replace(study, delay=delay)))
    assert TorqueFinding._delay_sentence.fget(finding) == told
