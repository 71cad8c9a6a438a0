"""A joint under a free torque, of which the plain model is the result: the position is searched, else the torque."""

from __future__ import annotations

from pathlib import Path

import pytest

from haptid.discrepancy.finding.finding import Finding
from haptid.discrepancy.finding.torque_finding import TorqueFinding
from haptid.discrepancy.job import search
from haptid.discrepancy.job.job import Job
from haptid.discrepancy.job.search import SearchByPosition, SearchByTorque, prepare_alone
from haptid.discrepancy.torque import choice
from haptid.identification.sequence.carried_fit import EarlierResidual
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.support.errors import NumericalError
from haptid.support.listener import ignore_progress
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import INPUTS, KNOWN, TRUTH

HIDDEN = {"cubic_spring": {"spring_cubic": 2e-2}}


@pytest.fixture(autouse=True)
def _identified_as_plain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(choice, "earlier_residual", lambda *_: EarlierResidual(at_noise=False, plain=True))


def found(tmp_path: Path, searched: str) -> tuple[Finding | TorqueFinding, Path]:
    sensor = Sensor(noise=2e-4, resolution=0.0)
    make_joint_campaign(tmp_path / "c", 3, TRUTH, INPUTS, effects=HIDDEN, sensor=sensor, known=KNOWN, seed=5)
    known = {key: effect for key, effect in catalogue().items() if effect.id == searched}
    job = Job(campaign=prepare(read_campaign(tmp_path / "c")), catalogue=known, out=tmp_path / "out", starts=4)
    prepared = prepare_alone(job, 3)
    assert isinstance(prepared, SearchByPosition)
    made = prepared.find(ignore_progress)
    return made, tmp_path / "out" / "fmu"


@pytest.mark.long
def test_an_effect_that_closes_the_gap_in_position_stands(tmp_path: Path):
    made, fmus = found(tmp_path, "cubic_spring")
    assert isinstance(made, Finding)
    assert made.closes_half
    assert [path.name for path in fmus.glob("*.fmu")] == ["joint3_cubic_spring.fmu"]


@pytest.mark.long
def test_where_no_effect_closes_the_gap_in_position_the_torque_is_searched(tmp_path: Path):
    made, fmus = found(tmp_path, "cogging")
    assert isinstance(made, TorqueFinding)
    assert made.fmu is None or [path.name for path in fmus.glob("*.fmu")] == [made.fmu.path.name]


@pytest.mark.long
def test_the_fmu_of_effects_that_do_not_stand_is_taken_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(Finding, "closes_half", False)
    monkeypatch.setattr(SearchByTorque, "find", lambda *_: None)
    made, fmus = found(tmp_path, "cubic_spring")
    assert made is None
    assert fmus.is_dir()  # the position named the effect, and its FMU was built
    assert not list(fmus.glob("*.fmu"))


@pytest.mark.long
def test_where_no_simulation_of_the_position_is_finite_the_torque_is_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def fail(*_: object, **__: object) -> Finding:
        raise NumericalError("no start of the fit gives a finite simulation")

    monkeypatch.setattr(search, "find", fail)
    made, _ = found(tmp_path, "cogging")
    assert isinstance(made, TorqueFinding)
