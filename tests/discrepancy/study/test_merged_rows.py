"""Rows of long recordings are merged where the torque changes little between them, and where no reading shows it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptid.discrepancy.detect.merged_error import merging_error, merging_shows
from haptid.discrepancy.search.nominal_model import fit_nominal_model
from haptid.discrepancy.search.search import search
from haptid.discrepancy.study.merged_rows import merged, rows_to_merge
from haptid.discrepancy.study.study import Study, study_of
from haptid.measurement.checks.preparation import prepare
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.signals.merged_rows import merge_rows, spline_torques
from haptid.measurement.values.run import Run
from haptid.model.effects.registry import catalogue
from haptid.support.listener import ignore_progress
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.discrepancy.finding.test_finding import KNOWN, TRUTH


def run_of(u: np.ndarray, t: np.ndarray, **more: Any) -> Run:
    given = {
        "file": "a.csv", "free_joints": (0,), "t": t, "u": u[:, None], "y": np.cos(t)[:, None], "noise": [1e-5],
        "resolution": [0.0], "posture": [], "use": "fit", "averaged_rows": 1,
    }  # fmt: skip
    return Run(**{**given, **more})


def moved_freely(t: np.ndarray, u: np.ndarray, hold: str) -> np.ndarray:
    """Return ∬u dt² at every row, by the exact integral of each interval."""
    speed, place, travelled = 0.0, 0.0, [0.0]
    for k in range(t.size - 1):
        dt, before, after = t[k + 1] - t[k], u[k], u[k] if hold == "zero" else u[k + 1]
        place += speed * dt + before * dt**2 / 2 + (after - before) * dt**2 / 6
        speed += (before + after) * dt / 2
        travelled.append(place)
    return np.array(travelled)


@given(
    every=st.integers(2, 6), rows=st.integers(14, 60), hold=st.sampled_from(["zero", "linear"]), seed=st.integers(0, 99)
)
def test_a_free_mass_passes_the_same_positions_at_the_kept_rows(every: int, rows: int, hold: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(1e-3 * rng.uniform(0.8, 1.2, rows - 1))])
    u = rng.standard_normal(rows)
    few = merge_rows(run_of(u, t, hold=hold), every)
    expected = moved_freely(t, u, hold)[::every]
    found = moved_freely(few.t, few.u[:, 0], "linear")
    assert few.hold == "linear"
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_what_is_kept_is_what_was_recorded() -> None:
    t = np.arange(0.0, 0.05, 1e-3)
    run = run_of(np.sin(t), t, v=-np.sin(t)[:, None], score_from=7, extra={"temperature_C": 20 + t})
    few = merge_rows(run, 4)
    assert few.t == pytest.approx(t[::4])
    assert few.y == pytest.approx(run.y[::4])
    assert few.v == pytest.approx(run.v[::4])
    assert few.extra["temperature_C"] == pytest.approx((20 + t)[::4])
    assert few.score_from == 2, "row 8 is the first one that is kept of those that are scored"
    assert spline_torques(run.but(hold="linear"), 4)[:, 0] == pytest.approx(np.sin(t[::4]), abs=1e-5)


def recorded(folder: Path, effects: dict[str, dict[str, float]], spacing: float = 1e-3) -> Study:
    """Return the study of a joint of the virtual device, recorded for three times ten seconds to fit."""
    inputs = tuple(
        Cosine(amplitude=a, frequency=w, use=use, duration=10.0, spacing=spacing)
        for a, w, use in ((0.008, 1.5, "fit"), (0.006, 2.5, "fit"), (0.009, 3.5, "fit"), (0.007, 2.0, "validate"))
    )
    sensor = Sensor(noise=2e-4, resolution=0.0)
    make_joint_campaign(folder, 3, TRUTH, inputs, effects=effects, sensor=sensor, known=KNOWN, seed=5)
    return study_of(prepare(read_campaign(folder)), 3, {"cubic_spring": catalogue()["cubic_spring"]})


def test_rows_are_merged_where_there_are_many_and_the_torque_changes_little(tmp_path: Path) -> None:
    whole = recorded(tmp_path / "c", {})
    assert whole.rows == 30_003
    assert rows_to_merge(whole) == 2
    few = merged(whole, 2)
    assert few.rows_merged == 2
    assert [run.t.size for run in (*few.fitted, *few.unseen)] == [5001] * 4
    short = replace(whole, fitted=whole.fitted[:2])
    assert rows_to_merge(short) == 1
    averaged = replace(whole, fitted=tuple(run.but(averaged_rows=3) for run in whole.fitted))
    assert rows_to_merge(averaged) == 1
    rng = np.random.default_rng(0)
    rough = replace(whole, fitted=tuple(run.but(u=rng.standard_normal(run.u.shape)) for run in whole.fitted))
    assert rows_to_merge(rough) == 1


@pytest.mark.long
def test_the_spring_of_a_long_recording_is_named_from_merged_rows(tmp_path: Path) -> None:
    k3 = 0.02
    whole = recorded(tmp_path / "c", {"cubic_spring": {"spring_cubic": k3}})
    found = search(whole, starts=2)
    assert found.study.rows_merged == 2
    assert found.best.solution.keys == ("cubic_spring",)
    assert found.best.solution.values["k3"] == pytest.approx(k3, rel=0.05)
    assert merging_error(whole, found.study, found.best.solution) < 0.5


def test_merging_that_shows_is_taken_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = recorded(tmp_path / "c", {})
    few, base = fit_nominal_model(merged(whole, 2), seed=0, starts=1, tell=ignore_progress)
    assert not merging_shows(whole, few, base.solution)
    # A torque that changes within merged rows moves the joint otherwise.
    slow = replace(whole, fitted=tuple(run.but(u=np.roll(run.u, 1, axis=0) * 1.01) for run in whole.fitted))
    assert merging_shows(slow, few, base.solution)
    monkeypatch.setattr("haptid.discrepancy.search.search.merging_shows", lambda *_: True)
    assert search(whole, starts=1).study.rows_merged == 1
