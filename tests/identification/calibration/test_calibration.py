"""Calibration of reference FMUs by the command: the values come back, the files hold them, errors are one line."""

from __future__ import annotations

import json
import shutil
from xml.etree import ElementTree

import fmpy
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from docs.parts.shown_code import blocks_of
from haptid.identification.run import main as identify
from haptid.measurement.check import main as check
from haptid.support.installing.environment import ROOT
from tests.identification.calibration_cases import BALL, DECAY, write_ball, write_decay
from tests.identification.foreign.test_model_exchange import exchange_only
from tests.real_data import DATA

pytestmark = pytest.mark.real("foreign_fmus")
FAST = ("--quiet", "--workers", "1", "--method", "gauss_newton")


def run(command, *arguments):
    return CliRunner().invoke(command, [str(a) for a in arguments])


def calibrated(folder, out, *arguments):
    done = run(identify, folder, "--out", out, *FAST, *arguments)
    assert done.exit_code == 0, done.output
    return json.loads((out / "identification.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def decay(tmp_path_factory):
    return write_decay(tmp_path_factory.mktemp("decay"))


@pytest.fixture(scope="module")
def identified(decay, tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    return out, calibrated(decay, out)


def near(parameters, name, truth, errors=3.0):
    one = parameters[name]
    assert abs(one["value"] - truth) <= errors * one["std"], one
    assert one["status"] == "identified"


def test_a_parameter_that_is_fixed_after_initialisation_is_found(identified):
    _, data = identified
    (one,) = data["configurations"]
    assert "free_joints" not in one
    near(one["parameters"], "k", 0.63)
    assert one["parameters"]["k"]["std"] < 0.002
    assert one["outcome"] == "converged"
    assert [(r["file"], r["use"]) for r in one["runs"]] == [("a.csv", "fit"), ("b.csv", "validate")]
    for entry in one["runs"]:
        assert entry["rmse_over_noise"]["x"] == pytest.approx(entry["rmse"]["x"] / 0.005)
        assert 0.6 < entry["rmse_over_noise"]["x"] < 1.4


def test_the_results_hold_the_value_as_fmu_and_as_parameter_set(identified):
    out, data = identified
    value = data["configurations"][0]["parameters"]["k"]["value"]
    fmu = out / "identified.fmu"
    description = fmpy.read_model_description(str(fmu))
    starts = {v.name: float(v.start) for v in description.modelVariables if v.start is not None}
    assert starts == {"x": 1.0, "k": value}
    assert not fmpy.validation.validate_fmu(str(fmu))
    result = fmpy.simulate_fmu(str(fmu), stop_time=1.0, output_interval=0.1, start_values=starts, output=["x"])
    assert result["x"][-1] == pytest.approx((1 - 0.1 * value) ** 10, rel=1e-9)
    tree = ElementTree.parse(out / "parameters.ssv")
    (parameter,) = tree.iter("{http://ssp-standard.org/SSP1/SystemStructureParameterValues}Parameter")
    assert (parameter.get("name"), float(parameter[0].get("value"))) == ("k", value)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "SYNTHETIC" in page.upper()
    assert "decay.fmu" in page


def test_the_program_of_the_page_simulates_the_identified_fmu(identified, tmp_path, monkeypatch):
    out, data = identified
    (program,) = blocks_of(ROOT / "docs" / "how-to" / "foreign_fmu.md", "python")
    (tmp_path / "results").symlink_to(out)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(program, names)
    assert names["values"] == {"k": data["configurations"][0]["parameters"]["k"]["value"]}
    assert names["result"]["time"][-1] == pytest.approx(5.0)
    assert np.isfinite(names["result"]["x"]).all()


def test_the_same_seed_gives_the_same_numbers_with_processes_too(decay, identified, tmp_path, monkeypatch):
    _, first = identified
    monkeypatch.setattr("haptid.identification.calibration.calibrate.expected_duration", lambda *_: 1e9)
    again = calibrated(decay, tmp_path / "out", "--workers", "2")
    for key in ("parameters", "runs", "covariance", "basins", "cost"):
        assert again["configurations"][0][key] == first["configurations"][0][key]


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_events_do_not_hide_the_minimum(version, tmp_path):
    data = calibrated(write_ball(tmp_path / "ball", version), tmp_path / "out")
    (one,) = data["configurations"]
    near(one["parameters"], "g", -9.3)
    near(one["parameters"], "e", 0.82)
    assert one["outcome"] == "converged"
    assert one["parameters"]["g"]["unit"] == "m/s2"


def test_an_fmu_for_model_exchange_is_calibrated_from_the_command_line(tmp_path):
    folder = write_decay(tmp_path / "decay")
    t = np.linspace(0.0, 4.0, 41)
    rng = np.random.default_rng(3)
    for file, start in (("a.csv", 2.0), ("b.csv", 1.0)):
        level = start * np.exp(-0.63 * t) + 0.005 * rng.standard_normal(t.size)
        pd.DataFrame({"time_s": t, "level": level}).to_csv(folder / file, index=False)
    (folder / "campaign.toml").write_text(DECAY.replace('model = "decay.fmu"\n', ""), encoding="utf-8")
    fmu = exchange_only(tmp_path, "fmi3/Dahlquist")
    near(calibrated(folder, tmp_path / "out", "--model", fmu)["configurations"][0]["parameters"], "k", 0.63)


def feedthrough(folder, output="Float64_continuous_output"):
    """Write a campaign whose output is its input of the column."""
    folder.mkdir()
    shutil.copy(DATA / "foreign_fmus" / "fmi3" / "Feedthrough.fmu", folder / "f.fmu")
    t = np.arange(20) * 0.1
    pd.DataFrame({"time_s": t, "force_N": np.sin(t), "count": np.arange(20)}).to_csv(folder / "a.csv", index=False)
    (folder / "campaign.toml").write_text(
        f"""[campaign]
measured = false
model = "f.fmu"
[inputs]
Float64_continuous_input = {{ column = "force_N" }}
Int32_input = {{ column = "count" }}
[outputs]
{output} = {{ column = "force_N", noise = 0.1 }}
Int32_output = {{ column = "count", noise = 0.5 }}
[parameters]
Float64_fixed_parameter = {{ fixed = 2.0 }}
[[runs]]
file = "a.csv"
use = "fit"
""",
        encoding="utf-8",
    )
    return folder


def test_columns_are_the_inputs_and_fixed_parameters_alone_are_scored(tmp_path):
    data = calibrated(feedthrough(tmp_path / "f"), tmp_path / "out")
    (one,) = data["configurations"]
    assert one["outcome"] == "fixed"
    assert one["parameters"]["Float64_fixed_parameter"]["status"] == "fixed"
    assert one["runs"][0]["rmse"] == {"Float64_continuous_output": 0.0, "Int32_output": 0.0}


def test_a_parameter_that_does_nothing_is_told_unidentifiable(tmp_path):
    folder = feedthrough(tmp_path / "f")
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    text = text.replace("{ fixed = 2.0 }", "{ initial = 2.0, lower = 0.0, upper = 9.0 }")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    data = calibrated(folder, tmp_path / "out")
    assert data["configurations"][0]["parameters"]["Float64_fixed_parameter"]["status"] == "unidentifiable"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("k = { initial", "kk = { initial", "campaign.toml, line 8, parameters.kk: expected a variable of decay.fmu"),
        ("k = { initial = 1.0, lower = 0.1, upper = 5.0 }", '"der(x)" = { initial = 1.0 }', "calculated local"),
        ('"level", noise', '"lvl", noise', "a.csv, line 1: expected a column lvl"),
        ("x = { column", "y = { column", "outputs.y: expected a variable of decay.fmu"),
        ("start = { x = 2.0 }", "start = { k = 2.0 }", "start values that are no parameters, got k"),
        ("start = { x = 2.0 }", "start = { z = 2.0 }", "runs[0].start: expected a variable of decay.fmu"),
        ('model = "decay.fmu"', 'model = "none.fmu"', "campaign.model: expected the file of an FMU"),
        ("initial = 1.0, lower", "initial = 9.0, lower", "parameters.k: expected values within the bounds"),
        ("noise = 0.005", "noise = 0.0", "expected a positive number"),
        ("k = {", "k.initial = {", "parameters.k.initial: expected a finite number"),
        ("[outputs]", "[output]", "did you mean outputs"),
    ],
)
def test_what_is_wrong_with_a_campaign_is_one_line_in_both_commands(decay, tmp_path, old, new, told):
    folder = shutil.copytree(decay, tmp_path / "c")
    assert old in DECAY
    (folder / "campaign.toml").write_text(DECAY.replace(old, new, 1), encoding="utf-8")
    lines = []
    for command, more in ((check, ()), (identify, ("--out", tmp_path / "out"))):
        done = run(command, folder, "--quiet", *more)
        assert done.exit_code == 2, done.output
        (line,) = done.output.strip().splitlines()
        lines.append(line)
    assert told in lines[0]
    assert lines[0] == lines[1]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("e = { initial", "v_min = { initial", "parameters.v_min: expected a variable that can be set before"),
        ("upper = 1.0", "upper = 2.0", "bounds in [0.5, 1], as the FMU says, got [0.5, 2]"),
    ],
)
def test_what_the_fmu_does_not_allow_is_refused(tmp_path, old, new, told):
    folder = write_ball(tmp_path / "ball")
    (folder / "campaign.toml").write_text(BALL.replace(old, new, 1), encoding="utf-8")
    done = run(check, folder)
    assert done.exit_code == 2
    assert told in done.output


def test_check_says_what_is_in_the_campaign(decay):
    done = run(check, decay)
    assert done.exit_code == 0, done.output
    assert "decay.fmu (FMI 2.0, co-simulation), synthetic data, 2 runs (1 fit, 1 validate, 0 excluded)" in done.output
    assert "parameters to fit k" in done.output


def test_commands_about_joints_name_the_one_that_takes_an_fmu(decay, tmp_path):
    from haptid.discrepancy.run import main as discrepancy  # noqa: PLC0415 # slow to import

    done = run(discrepancy, decay, "--joint", "0", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "python -m identification.run" in done.output
