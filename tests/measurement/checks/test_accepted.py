"""Every command accepts and refuses the same campaigns, in the same words, and remarks the same."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from haptid.discrepancy.run import main as discrepancy
from haptid.identification.run import main as identify
from haptid.measurement.check import main as check
from haptid.measurement.checks.preparation import prepare_campaign
from haptid.measurement.checks.stated import overridden
from haptid.measurement.format.reading import read_campaign
from haptid.model.joint.locked_joint import joint_equations
from haptid.uq.run import main as uq
from tests.identification.bench_joint import TRUE, make_run

COMMANDS = {"check": check, "identify": identify, "uq": uq, "discrepancy": discrepancy}
TOML = """[campaign]
device = "single_joint"
measured = false

[sensor]
noise_rad = 2e-4

[[runs]]
file = "a.csv"
free_joints = [4]
use = "fit"

[[runs]]
file = "b.csv"
free_joints = [4]
use = "validate"
"""
T, Q = "torque_4_Nm", "position_4_rad"


@pytest.fixture(scope="session")
def tables() -> dict[str, pd.DataFrame]:
    made = {"a.csv": make_run(0.005, 6.283, seed=1), "b.csv": make_run(0.005, 10.68, seed=2)}
    return {name: pd.DataFrame({"time_s": r.t, T: r.u[:, 0], Q: r.y[:, 0]}) for name, r in made.items()}


@pytest.fixture
def write(tmp_path: Path, tables: dict[str, pd.DataFrame]) -> Callable[..., Path]:
    def written(old: str = "", new: str = "", change: Callable[[pd.DataFrame], object] | None = None) -> Path:
        folder = tmp_path / "c"
        folder.mkdir()
        (folder / "campaign.toml").write_text(TOML.replace(old, new, 1) if old else TOML + new, encoding="utf-8")
        for name, table in tables.items():
            frame = table.copy()
            if change is not None:
                change(frame)
            frame.to_csv(folder / name, index=False)
        return folder

    return written


def call(command: str, folder: Path, *options: str) -> Result:
    out = [] if command == "check" else ["--out", str(folder.parent / "out"), "--quiet", "--workers", "1", *options]
    return CliRunner().invoke(COMMANDS[command], [str(folder), *out])


def scaled(column: str, factor: float) -> Callable[[pd.DataFrame], object]:
    return lambda frame: frame.update(frame[[column]] * factor)


def gap(seconds: float) -> Callable[[pd.DataFrame], object]:
    return lambda frame: frame.update(frame.loc[600:, ["time_s"]] + seconds)


def parameters(text: str) -> tuple[str, str]:
    return "", f"\n[joint.4.parameters]\n{text}\n"


NO_CHANGE = ("", "")
REFUSED = [
    (NO_CHANGE, scaled("time_s", 1e3), r"a.csv, time_s: expected time in seconds"),
    (NO_CHANGE, scaled("time_s", 1e-300), "expected time in seconds, with rows 1e-09 s apart at least"),
    (NO_CHANGE, gap(11.0), "expected no gap above 10 s, got 11 s"),
    (NO_CHANGE, gap(1e6), "expected no gap above 10 s, got 1e+06 s"),
    (NO_CHANGE, scaled(Q, 0.0), "moves more than 10 times the sensor's noise"),
    (NO_CHANGE, scaled(Q, 1e99), "expected a position up to 1e+09 rad"),
    (NO_CHANGE, scaled(T, 1e90), "expected a torque up to 1e+12 N m"),
    (NO_CHANGE, scaled(T, 1e-90), "expected a torque of 1e-15 N m at least"),
    (("noise_rad = 2e-4", "noise_rad = 100"), None, "noise 100 (stated); correct noise or resolution under [sensor]"),
    (parameters("inertia = { upper = -1.0 }"), None, "campaign.toml, line 19, joint.4.parameters.inertia: expected"),
    (parameters("sigma0 = { initial = -5.0 }"), None, "line 19, joint.4.parameters.sigma0: expected"),
    (parameters("Kp = { fixed = 1e300 }"), None, "line 19, joint.4.parameters.Kp: expected"),
]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(("text", "change", "words"), REFUSED, ids=[f"{k}" for k in range(len(REFUSED))])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_every_command_refuses_alike(write, command, text, change, words):
    folder = write(*text, change)
    result = call(command, folder)
    assert result.exit_code == 2
    assert words in result.output
    assert result.output.startswith(f"error: {folder}/")
    assert result.output.count("\n") == 1
    out = folder.parent / "out"
    assert not out.exists() or not any(path.is_file() and path.name[0] != "." for path in out.rglob("*"))


def test_with_everything_fixed_the_stated_model_is_scored(write):
    stated = {**TRUE, "Kp": 1.0, "gravity_cos": 0.0, "gravity_sin": 0.0}
    folder = write(*parameters("\n".join(f"{id} = {{ fixed = {value} }}" for id, value in stated.items())))
    result = call("identify", folder, "--fmu", "none", "--no-export")
    assert result.exit_code == 0, result.output
    (step,) = json.loads((folder.parent / "out" / "identification.json").read_text())["configurations"]
    assert step["outcome"] == "fixed"
    assert all(run["rmse_over_noise"] == pytest.approx(1.0, abs=0.1) for run in step["runs"])


def test_remarks_reach_the_log_the_result_and_the_report(write):
    folder = write(change=scaled(T, -1.0))
    told = [line for line in call("check", folder).output.splitlines() if "sign wrong" in line]
    result = call("identify", folder, "--fmu", "none", "--no-export", "--starts", "1")
    assert result.exit_code == 0, result.output
    logged = [line for line in result.stderr.splitlines() if line.startswith("remark: ")]
    assert [line.strip() for line in told] == [line.removeprefix("remark: ") for line in logged]
    data = json.loads((folder.parent / "out" / "identification.json").read_text())
    assert [f"remark: {sentence}" for sentence in data["remarks"]] == logged
    assert data["configurations"][0]["outcome"] in ("unexplained", "lonely", "above_noise")
    page = (folder.parent / "out" / "report.html").read_text()
    assert "Remarks on the data" in page
    assert "is the torque" in page


def test_a_torque_that_never_changes_is_told_as_that(write):
    folder = write(change=lambda frame: frame.update(pd.DataFrame({T: np.full(len(frame), 0.002)})))
    result = call("identify", folder, "--fmu", "none", "--no-export", "--starts", "1")
    assert result.exit_code == 0, result.output
    assert "remark: a.csv, b.csv, joint 4: the torque never changes: nothing excites the joint" in result.stderr
    assert "the torque never changes in the fitted runs" in result.stdout


@pytest.mark.parametrize(("factor", "told"), [(1.0, False), (1e3, True)])
def test_torque_at_odds_with_the_stated_inertia_is_remarked(write, factor: float, told: bool):
    folder = write(*parameters("inertia = { initial = 1e-4 }"), scaled(T, factor))
    result = call("check", folder)
    assert result.exit_code == 0, result.output
    assert ("is the torque in thousandths of its unit?" in result.output) is told


def test_with_everything_fixed_nothing_is_sampled(write):
    stated = {**TRUE, "Kp": 1.0, "gravity_cos": 0.0, "gravity_sin": 0.0}
    folder = write(*parameters("\n".join(f"{id} = {{ fixed = {value} }}" for id, value in stated.items())))
    result = call("uq", folder)
    assert result.exit_code == 2
    assert "joint.4.parameters: expected a parameter whose posterior is wanted, got all fixed" in result.output


@pytest.mark.parametrize("command", ["identify", "uq", "discrepancy"])
def test_bad_options_are_one_line_whatever_is_remarked(write, command: str):
    result = call(command, write(change=scaled(T, -1.0)), "--joints", "x")
    assert result.exit_code == 2
    assert result.output.count("\n") == 1


def test_a_lower_bound_of_zero_is_taken_on_what_is_positive(write):
    folder = write(*parameters("sigma2 = { lower = 0 }\ninertia = { initial = 1e-8, lower = 0.0, upper = 0.1 }"))
    assert call("check", folder).exit_code == 0
    campaign = prepare_campaign(read_campaign(folder))
    fitted = overridden(joint_equations(4), campaign.parameter_overrides[4], 4)
    lower = {q.id: q.lower for q in fitted.parameters}
    assert (lower["sigma2"], lower["inertia"]) == (1e-8, 1e-8)


def test_a_device_that_cannot_be_is_refused_before_anything_is_said(write):
    folder = write('"single_joint"', '"mine.toml"')
    (folder / "mine.toml").write_text('name = "mine"\n', encoding="utf-8")
    refusals = [call(command, folder) for command in COMMANDS]
    assert {result.exit_code for result in refusals} == {2}
    assert all(result.output.startswith(f"error: {folder}/mine.toml") for result in refusals)
    assert {result.output for result in refusals} == {refusals[0].output}
