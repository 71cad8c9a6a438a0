"""Calibration of small FMUs that are compiled here: what fails in their code is one line, in every command."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from haptid.identification.calibration.calibrate import largest_residual_of_noise
from haptid.identification.calibration.difference_steps import choose
from haptid.identification.calibration.start_values import with_starts
from haptid.identification.run import main as identify
from haptid.measurement.check import main as check
from haptid.support.errors import InputError
from tests.identification.foreign_cases import DESCRIPTION, content, write

CAMPAIGN = """[campaign]
measured = false
[inputs]
force = { column = "force_N" }
[outputs]
position = { column = "position" }
[parameters]
position = { initial = 0.0, lower = -9.0, upper = 9.0 }
[[runs]]
file = "a.csv"
use = "fit"
"""


@pytest.fixture
def folder(tmp_path):
    """Campaign about x_{k+1} = x_k + h·u_k from x = 2."""
    made = tmp_path / "campaign"
    made.mkdir()
    t = np.arange(60) * 0.05
    force = np.cos(t)
    x = 2.0 + np.concatenate(([0.0], np.cumsum(np.diff(t) * force[:-1])))
    noisy = x + 0.01 * np.random.default_rng(1).standard_normal(t.size)
    pd.DataFrame({"time_s": t + 7.0, "force_N": force, "position": noisy}).to_csv(made / "a.csv", index=False)
    (made / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    return made


def run(command, *arguments):
    return CliRunner().invoke(command, [str(a) for a in arguments])


def test_a_description_that_breaks_a_rule_beyond_the_schema_is_told_and_runs(folder, tmp_path):
    files = content()
    xml = files["modelDescription.xml"]
    broken = xml.replace(b'<Real start="0"/>', b"<Real/>", 1)
    assert broken != xml
    fmu = write(tmp_path / "small.fmu", files | {"modelDescription.xml": broken})
    for command in ((check,), (identify, "--out", tmp_path / "out", "--workers", "1")):
        done = run(*command, "--model", fmu, folder, "--quiet")
        assert done.exit_code == 0, done.output
        assert 'breaks the FMI standard, and hosts that validate refuse it: Variable "force"' in done.output
    assert "Variable &#34;force&#34;" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_uneven_rows_for_an_fmu_of_equal_steps_are_told(folder, tmp_path):
    files = content()
    promise = b' canHandleVariableCommunicationStepSize="true"'
    assert promise in files["modelDescription.xml"]
    equal = files | {"modelDescription.xml": files["modelDescription.xml"].replace(promise, b"")}
    table = pd.read_csv(folder / "a.csv")
    for rows, archive, told in (
        (table, equal, False),
        (table.drop(index=7), equal, True),
        (table.drop(index=7), files, False),
    ):
        rows.to_csv(folder / "a.csv", index=False)
        done = run(check, "--model", write(tmp_path / "small.fmu", archive), folder, "--quiet")
        assert done.exit_code == 0, done.output
        assert ("a.csv are not evenly spaced, and the FMU does not promise" in done.output) == told


def test_thirty_readings_of_noise_alone_are_no_missing_model(folder, tmp_path):
    """Noise whose RMS is by chance 1.1 times what is stated, as in one of four sets of so few readings."""
    table = pd.read_csv(folder / "a.csv").iloc[:30]
    ideal = 2.0 + np.concatenate(([0.0], np.cumsum(np.diff(table["time_s"]) * table["force_N"][:-1])))
    noise = np.random.default_rng(4).standard_normal(len(table))
    noise -= noise.mean()
    table["position"] = ideal + 0.011 * noise / np.sqrt(np.mean(noise**2))
    table.to_csv(folder / "a.csv", index=False)
    text = CAMPAIGN.replace('{ column = "position" }', '{ column = "position", noise = 0.01 }')
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    fmu = write(tmp_path / "small.fmu", content())
    done = run(identify, "--model", fmu, folder, "--out", tmp_path / "out", "--quiet", "--workers", "1")
    assert done.exit_code == 0, done.output
    (one,) = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))["configurations"]
    assert one["outcome"] == "converged"


def test_the_residual_that_noise_alone_leaves():
    rng = np.random.default_rng(1)
    for readings in (30, 300):
        rms = np.sqrt(np.mean(rng.standard_normal((4000, readings)) ** 2, axis=1))
        assert 0.0002 < np.mean(rms > largest_residual_of_noise(readings)) < 0.01
    assert largest_residual_of_noise(10_000) < 1.03


def test_an_initial_state_is_identified_with_the_noise_estimated(folder, tmp_path):
    fmu = write(tmp_path / "small.fmu", content())
    done = run(identify, "--model", fmu, folder, "--out", tmp_path / "out", "--quiet", "--workers", "1")
    assert done.exit_code == 0, done.output
    (one,) = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))["configurations"]
    found = one["parameters"]["position"]
    assert abs(found["value"] - 2.0) < 4 * found["std"]
    assert found["std"] == pytest.approx(0.01 / np.sqrt(60), rel=0.5)
    assert one["outputs"]["position"]["noise"] == pytest.approx(0.01, rel=0.3)
    assert 'no run has use = "validate"' in done.output


@pytest.mark.parametrize(
    ("step", "told"),
    [
        ("crashes", "small.fmu: its own code ended the process (signal SIG"),
        ("reports an error", "small.fmu: fmi2DoStep failed with status 3"),
        ("overflows", "small.fmu: its output position is inf"),
        ("hangs", "small.fmu: no answer within 0.5 s: it was ended; raise --simulation-limit where it is only slow"),
    ],
)
def test_code_that_fails_is_one_line_in_both_commands(step, told, folder, tmp_path):
    fmu = write(tmp_path / "small.fmu", content(step))
    for command, more in ((check, ()), (identify, ("--out", tmp_path / "out"))):
        done = run(command, "--model", fmu, folder, "--quiet", "--simulation-limit", 0.5, *more)
        assert done.exit_code == 1
        (line,) = done.output.strip().splitlines()
        assert told in line


def test_values_that_the_fmu_refuses_are_avoided(folder, tmp_path):
    text = CAMPAIGN.replace("initial = 0.0", "initial = 3.5").replace("upper = 9.0", "upper = 40.0")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    fmu = write(tmp_path / "small.fmu", content("refuses"))
    done = run(identify, "--model", fmu, folder, "--out", tmp_path / "out", "--quiet", "--workers", "1")
    assert done.exit_code == 0, done.output
    (one,) = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))["configurations"]
    assert one["parameters"]["position"]["value"] == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--joints", "1"), "--joints: expected no such option for an FMU"),
        ((), "CAMPAIGN: expected the folder of a campaign about the FMU"),
    ],
)
def test_options_that_an_fmu_has_no_use_for_are_refused(arguments, told, folder, tmp_path):
    fmu = write(tmp_path / "small.fmu", content())
    named = (folder,) if arguments else ()
    done = run(identify, "--model", fmu, *named, "--out", tmp_path / "out", "--quiet", *arguments)
    assert done.exit_code == 2
    assert told in done.output


def test_an_fmu_without_this_platforms_binary_is_refused(folder, tmp_path):
    files = {name.replace("binaries/", "binaries/other/"): data for name, data in content().items()}
    done = run(check, "--model", write(tmp_path / "small.fmu", files), folder)
    assert done.exit_code == 2
    assert "for this platform" in done.output


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ([1e-9, 1e-8, 1e-7, 1e-6, 1e-5], 0),  # smooth: the narrowest
        ([1e-3, 1e-2, 0.1, 0.6, 1.4], 0),  # smooth, but the wide steps see its curvature
        ([0.0, 0.0, 1.03, 0.26, 0.23], 4),  # narrow steps miss the jumps altogether
        ([0.0, 0.75, 0.32, 0.24, 0.41], 3),
        ([2.0, 1.9, 0.9, 0.7, 1.1], 3),  # nothing agrees: what changes least
    ],
)
def test_the_step_is_wide_only_where_events_ask_for_it(changes, place):
    assert choose(changes) == place


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_start_values_change_and_nothing_else(encoding):
    text = DESCRIPTION.replace("UTF-8", encoding.removesuffix("-sig")).replace('modelName="small"', 'modelName="größe"')
    changed = with_starts(text.encode(encoding), {"position": 2.5}, "small.fmu").decode(encoding)
    assert changed == text.replace('<Real start="0"/></Scalar', '<Real start="2.5"/></Scalar')


def test_a_start_value_is_added_where_there_is_none():
    third = b'<fmiModelDescription><ModelVariables><Float64 name="k" min="0" /></ModelVariables></fmiModelDescription>'
    changed = with_starts(third, {"k": 1e-3}, "x.fmu")
    assert b'<Float64 name="k" min="0" start="0.001"/>' in changed
    aliased = third.replace(b"/></Model", b'><Alias name="c"/></Float64></Model')
    assert b'<Float64 name="k" min="0" start="0.5"><Alias name="c"/>' in with_starts(aliased, {"c": 0.5}, "x.fmu")
    with pytest.raises(InputError, match="expected a variable z"):
        with_starts(third, {"z": 1.0}, "x.fmu")
