"""Posterior of a calibrated FMU: it goes on from the folder of the calibration, and nothing else."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.identification.run import main as identify
from haptid.uq.run import main as infer
from tests.identification.calibration_cases import DECAY, write_decay

pytestmark = pytest.mark.real("foreign_fmus")
QUICK = ("--quick", "--quiet", "--workers", "1")


def run(command, *arguments):
    return CliRunner().invoke(command, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    campaign = write_decay(folder / "campaign")
    done = run(identify, campaign, "--out", folder / "out", "--quiet", "--workers", "1", "--method", "gauss_newton")
    assert done.exit_code == 0, done.output
    return folder


@pytest.fixture(scope="module")
def inferred(calibrated):
    done = run(infer, calibrated / "out", *QUICK)
    assert done.exit_code == 0, done.output
    return json.loads((calibrated / "out" / "posterior.json").read_text(encoding="utf-8")), done.output


def test_the_posterior_agrees_with_the_fit_and_holds_the_truth(calibrated, inferred):
    data, output = inferred
    fit = json.loads((calibrated / "out" / "identification.json").read_text(encoding="utf-8"))
    one, fitted = data["parameters"]["k"], fit["configurations"][0]["parameters"]["k"]
    assert one["mean"] == pytest.approx(fitted["value"], abs=0.5 * fitted["std"])
    assert 0.6 < one["std"] / fitted["std"] < 1.6
    low, high = one["intervals"]["0.95"]
    assert low < 0.63 < high
    assert "k is known to" in output


def test_the_files_hold_draws_by_variable_and_bands(calibrated, inferred):
    data, _ = inferred
    with (calibrated / "out" / "parameters_posterior.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 500
    assert np.mean([float(row["k"]) for row in rows]) == pytest.approx(data["parameters"]["k"]["mean"], rel=1e-3)
    assert [run["file"] for run in data["runs"]] == ["a.csv", "b.csv"]
    assert all(run["covered"]["0.95"] > 0.8 for run in data["runs"])
    assert (calibrated / "out" / "posterior" / "model.nc").is_file()
    assert "decay.fmu" in (calibrated / "out" / "posterior.html").read_text(encoding="utf-8")


def test_the_same_seed_gives_the_same_draws_from_the_campaign_and_its_results(calibrated, inferred, tmp_path):
    data, _ = inferred
    moved = shutil.copytree(calibrated, tmp_path / "moved")  # the results name campaign and FMU from where they lie
    done = run(infer, moved / "campaign", "--out", moved / "out", *QUICK)
    assert done.exit_code == 0, done.output
    again = json.loads((moved / "out" / "posterior.json").read_text(encoding="utf-8"))
    assert again["parameters"] == data["parameters"]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda f: (f / "campaign" / "decay.fmu").unlink(), "model_file: expected the FMU, got no file"),
        (lambda f: (f / "campaign" / "decay.fmu").write_bytes(b"PK"), "expected the FMU that was calibrated"),
        (lambda f: (f / "out" / "identification.json").unlink(), "campaign.toml"),
        (
            lambda f: (f / "campaign" / "campaign.toml").write_text(DECAY.replace("k = {", "x = {"), encoding="utf-8"),
            "expected the parameters k, got x",
        ),
    ],
)
def test_what_no_longer_belongs_together_is_one_line(calibrated, tmp_path, change, told):
    moved = shutil.copytree(calibrated, tmp_path / "moved")
    change(moved)
    done = run(infer, moved / "out", *QUICK)
    assert done.exit_code == 2
    (line,) = done.output.strip().splitlines()
    assert told in line
