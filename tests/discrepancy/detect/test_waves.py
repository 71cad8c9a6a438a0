"""Ripple that a free simulation hides: waves beyond the grids are read from the torque along the measured motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptid.discrepancy.detect.rigid_residual import residual_over_position
from haptid.discrepancy.detect.waves import find_waves, with_waves
from haptid.discrepancy.search.search import search
from haptid.discrepancy.study.study import Study, study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.model.effects.registry import catalogue
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import KNOWN, TRUTH

NUMBER = 71.0
"""Waves a radian; the grid of cogging ends far below."""
KEYS = ("cogging", "torque_ripple", "cubic_spring")


def recorded(folder: Path, size: float) -> Study:
    """Return the study of a joint whose poles make waves of ``size`` N m."""
    inputs = tuple(
        Cosine(amplitude=a, frequency=w, use=use, duration=8.0, spacing=0.002)
        for a, w, use in ((0.008, 1.5, "fit"), (0.006, 2.5, "fit"), (0.009, 2.0, "validate"))
    )
    hidden = {"cogging": {"cogging": size, "cogging_phase": 0.4, "cogging_number": NUMBER}} if size else {}
    sensor = Sensor(noise=1e-5, resolution=0.0)
    make_joint_campaign(folder, 3, TRUTH, inputs, effects=hidden, sensor=sensor, known=KNOWN, seed=5)
    return study_of(prepare(read_campaign(folder)), 3, {key: catalogue()[key] for key in KEYS})


def in_si(study: Study) -> dict:
    return study.in_si({q.id: q.initial for q in study.base.parameters})


def grid(effect) -> tuple[float, ...]:
    return dict(effect.shapes)["cogging_number"]


def test_the_torque_along_the_motion_shows_the_wave_and_no_other(tmp_path: Path) -> None:
    study = recorded(tmp_path / "c", 5e-4)
    listed = in_si(study)
    highest = grid(listed["cogging"])[-1]
    assert highest < NUMBER / 2
    (found,) = find_waves(*residual_over_position(study.fitted), beyond=highest)
    assert found == pytest.approx(NUMBER, rel=0.02)
    wider = with_waves(listed, lambda: residual_over_position(study.fitted))
    assert grid(wider["cogging"]) == (*grid(listed["cogging"]), found)
    assert wider["cogging"].parameters[2].upper > NUMBER
    assert wider["cubic_spring"] == listed["cubic_spring"]


def test_a_joint_without_ripple_has_the_grids_of_the_catalogue(tmp_path: Path) -> None:
    study = recorded(tmp_path / "c", 0.0)
    listed = in_si(study)
    assert with_waves(listed, lambda: residual_over_position(study.fitted)) == listed


def test_nothing_is_asked_where_no_effect_has_waves_and_few_rows_show_none() -> None:
    listed = {"cubic_spring": catalogue()["cubic_spring"]}

    def refuse() -> tuple[np.ndarray, np.ndarray]:
        raise AssertionError

    assert with_waves(listed, refuse) == listed
    assert find_waves(np.zeros(0), np.zeros((0, 2)), beyond=1.0) == ()


@pytest.mark.parametrize("beyond", [20.0, 78.5, 100.0])
def test_a_wave_is_found_wherever_the_grid_ends(beyond: float) -> None:
    """Of a short travel the peak is wide: of a range that began beside it, it was taken for the level of noise."""
    rng = np.random.default_rng(2)
    q = 0.18 * np.sin(np.linspace(0.0, 400.0, 12000)) * np.linspace(0.4, 1.0, 12000)
    teeth = sum(a * np.sin(h * 119.0 * q + 0.8) for h, a in ((1, 1.6), (2, 0.3), (3, 0.25)))
    signal = (1.0 + 0.5 * np.sin(32.0 * q)) * teeth + 0.2 * rng.standard_normal(q.size)
    assert find_waves(q, signal[:, None], beyond=beyond)[0] == pytest.approx(119.0, rel=0.03)
    assert find_waves(q, rng.standard_normal((q.size, 1)), beyond=beyond) == ()


@pytest.mark.long
def test_the_ripple_is_named_by_its_number(tmp_path: Path) -> None:
    found = search(recorded(tmp_path / "c", 5e-4), starts=2)
    assert found.best.adequate
    assert found.best.solution.keys == ("cogging",)
    assert found.best.solution.values["cogging_number"] == pytest.approx(NUMBER, rel=0.01)
