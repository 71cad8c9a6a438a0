"""The first tutorial: its blocks run from top to bottom, print what the page shows, and find what is true."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from docs.from_runs import tutorial_page
from docs.from_runs.pendulum_tables import DURATION_S, FOLDER, NOISE_DEG, RATE_HZ, TESTS, TRUTH, simulate
from docs.from_runs.tutorial_page import MATCHES, Done, estimates_of, run_page

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="libcosimpy and the page's shell are there on Linux")
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
NOISE_BAND = 0.1
"""Share by which the RMS of 1,500 draws of noise may differ from their standard deviation."""


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Done]]:
    folder = tmp_path_factory.mktemp("tutorial")
    return folder, run_page(folder)


def masked(text: str) -> list[str]:
    """Words without their numbers: last digits, durations and digests differ between machines."""
    without_digest = re.sub(r"digest \w+", "digest", text)
    return NUMBER.sub("#", re.sub(r"-{3,}", "---", without_digest)).split()


@pytest.mark.long
def test_the_page_shows_what_its_blocks_print(ran):
    for done in ran[1]:
        assert masked(done.shown) == masked(done.printed), done.heading


@pytest.mark.long
def test_the_fit_finds_the_simulated_pendulum(ran):
    estimates = estimates_of(ran[0])
    for name, true in TRUTH.items():
        found = estimates[MATCHES.get(name, name)]
        assert found["status"] == "identified"
        assert abs(found["value"] - true) < 4 * found["std"], name
        assert found["std"] < 0.02 * true, name


@pytest.mark.long
def test_two_simulators_give_the_unseen_motion_to_its_noise(ran):
    said = ran[1][-2].printed + ran[1][-1].printed
    errors = [float(number) for number in re.findall(r"angle: ([\d.]+) deg RMS", said)]
    assert errors == pytest.approx([NOISE_DEG, NOISE_DEG], rel=NOISE_BAND)
    assert "less than 1e-6 deg: True" in said


def test_the_tables_of_the_page_are_those_of_the_stored_results():
    page = tutorial_page.PAGE.read_text(encoding="utf-8")
    stored = json.loads(tutorial_page.STORED.read_text(encoding="utf-8"))
    assert page == tutorial_page.with_tables(page, stored), "run python -m docs.from_runs.tutorial_page"


def test_the_shipped_tables_are_those_of_the_script():
    assert {path.stem for path in FOLDER.glob("*.csv")} == set(TESTS)
    for name, test in TESTS.items():
        table = pd.read_csv(FOLDER / f"{name}.csv", comment="#")
        t, torque, angle = simulate(test)
        assert len(table) == round(DURATION_S * RATE_HZ)
        np.testing.assert_allclose(table["Time (ms)"], 1e3 * t, atol=1e-9)
        np.testing.assert_allclose(table["Torque (N mm)"], 1e3 * torque, atol=1e-6)
        rest = table["Angle (deg)"] - np.degrees(angle)
        assert np.std(rest) == pytest.approx(NOISE_DEG, rel=NOISE_BAND)
        assert "SYNTHETIC" in (FOLDER / f"{name}.csv").read_text(encoding="utf-8").splitlines()[0]
