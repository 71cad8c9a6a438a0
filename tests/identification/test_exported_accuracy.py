"""The command's FMUs say how good they are: numbers of identification.json, and draws that any host can step."""

from __future__ import annotations

import html
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner
from fmpy.validation import validate_fmu

from haptid.fmu_build.exchange.archive import unpack
from haptid.fmu_build.export import main as export
from haptid.fmu_build.native.platforms import this_platform
from haptid.identification.run import main
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from tests.fmu_build.accuracy_cases import draws_of, json_of, page_of, table_of
from tests.fmu_build.fmu_cases import Client, names
from tests.identification.bench_joint import TRUE

COSINES = (
    Cosine(amplitude=0.005, frequency=1.13, duration=6.0),
    Cosine(amplitude=0.004, frequency=2.4, duration=6.0),
    Cosine(amplitude=0.0045, frequency=1.75, duration=6.0, use="validate"),
)
FAST = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton")


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder, results = tmp_path_factory.mktemp("campaign"), tmp_path_factory.mktemp("out")
    make_joint_campaign(folder, 4, {**TRUE, "Kp": 1.0}, COSINES, sensor=Sensor(noise=2e-4, resolution=1.5e-4), seed=4)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())
        done = CliRunner().invoke(main, [str(folder), "--out", str(results), *FAST])
        assert done.exit_code == 0, done.output
        yield results


@pytest.fixture(scope="module")
def tested(out: Path) -> dict[str, Any]:
    (one,) = json.loads((out / "identification.json").read_text())["configurations"]
    return one


def test_the_parameter_set_lies_beside_the_fmu_and_on_the_first_screen(out: Path):
    assert (out / "joint4.ssv").read_bytes() == unpack((out / "joint4.fmu").read_bytes())["resources/parameters.ssv"]
    assert 'href="joint4.ssv"' in (out / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["joint4.fmu", "joint4_native.fmu"])
def test_numbers_are_those_of_identification_json(out: Path, tested: dict[str, Any], name: str):
    path = out / name
    assert validate_fmu(str(path)) == []
    told = {row["name"]: row for row in table_of(path, "parameters.csv")}
    variables = names(joint_equations(4), joint_equations(4).parameters)
    for variable, q in zip(variables, joint_equations(4).parameters, strict=True):
        entry = tested["parameters"][q.id]
        row = told[variable]
        assert (float(row["value"]), float(row["std"])) == (entry["value"], entry["std"])
        assert (row["status"], row["unit"]) == (entry["status"], entry["unit"])
    verification = json_of(path, "verification.json")
    assert verification["synthetic"] is True
    rows = {(row["file"], row["mode"]): row for row in verification["joints"][0]["runs"]}
    for run in tested["runs"]:
        assert rows[run["file"], "as_fitted"]["rmse"] == run["rmse_rad"]
        assert rows[run["file"], "as_fitted"]["over_noise"] == run["rmse_over_noise"]
        assert rows[run["file"], "open_loop"]["rmse"] == run["figures"]["model"]["free_rmse"]
    digests, data = json_of(path, "digests.json"), json.loads((out / "identification.json").read_text())
    assert digests["data"] == {"4": tested["data"]}
    assert (digests["inputs"], digests["code"], digests["seed"]) == (data["inputs"], data["code"], 0)
    assert "SYNTHETIC DATA" in page_of(path)
    description = fmpy.read_model_description(str(path)).description
    assert "SYNTHETIC" in description
    assert "first guess" not in description


def test_draws_have_the_moments_of_the_fit(out: Path, tested: dict[str, Any]):
    path, e = out / "joint4.fmu", joint_equations(4)
    id_of = dict(zip(names(e, e.parameters), (q.id for q in e.parameters), strict=True))
    draws = draws_of(path)
    ids = [id_of[name] for name in draws[0]]
    assert len(draws) == 200
    assert set(ids) == set(tested["free"])
    drawn = np.array([list(draw.values()) for draw in draws])
    entries = [tested["parameters"][id] for id in ids]
    value, std = (np.array([entry[key] for entry in entries]) for key in ("value", "std"))
    # the standard error of a mean, and that of a standard deviation
    assert np.all(np.abs(drawn.mean(axis=0) - value) < 4 * std / np.sqrt(200))
    np.testing.assert_allclose(drawn.std(axis=0), std, rtol=4 / np.sqrt(400))
    stated = np.array([[float(x) for x in list(row.values())[1:]] for row in table_of(path, "correlation.csv")])
    places = [tested["free"].index(id) for id in ids]
    covariance = np.array(tested["covariance"])[np.ix_(places, places)]
    np.testing.assert_allclose(stated * np.outer(std, std), covariance, rtol=1e-9)
    np.testing.assert_allclose(np.corrcoef(drawn.T), stated, atol=4 / np.sqrt(200))


@pytest.mark.parametrize("name", ["joint4.fmu", "joint4_native.fmu"])
def test_a_draw_moves_as_its_values_say(out: Path, tested: dict[str, Any], name: str):
    e = joint_equations(4)
    parameters, draw = names(e, e.parameters), draws_of(out / name)[17]
    values = {
        variable: draw.get(variable, tested["parameters"][q.id]["value"])
        for variable, q in zip(parameters, e.parameters, strict=True)
    }
    t = 0.005 * np.arange(201)
    torque = 4e-3 * np.cos(2.0 * t)[:, None]
    client = Client(out / name)
    client.assign(list(draw), list(draw.values()))
    by_draw = client.start().go().run(e, t, torque)
    p = np.array([values[variable] for variable in parameters])
    np.testing.assert_array_equal(by_draw, CompiledKernel.of(e).simulate(t, torque, p, np.zeros(len(e.states))))


def test_the_lines_of_the_page_give_a_band(out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shutil.copy(out / "joint4_native.fmu", tmp_path / "joint4.fmu")
    monkeypatch.chdir(tmp_path)
    lines = html.unescape(page_of(tmp_path / "joint4.fmu").split("<pre>")[1].split("</pre>")[0])
    assert len(lines.splitlines()) <= 10
    made: dict[str, Any] = {}
    exec(lines, made)
    nominal = made["nominal"]["joint4.reading"]
    assert np.mean((made["lower"] <= nominal) & (nominal <= made["upper"])) > 0.9
    assert 0 < np.max(made["upper"] - made["lower"]) < 0.05 * np.ptp(nominal)


def test_an_export_from_the_file_is_the_same_fmu(out: Path, tmp_path: Path):
    arguments = ["--from", str(out / "identification.json"), "--kind", "native", "--out", str(tmp_path / "again.fmu")]
    done = CliRunner().invoke(export, arguments)
    assert done.exit_code == 0, done.output
    assert (tmp_path / "again.fmu").read_bytes() == (out / "joint4_native.fmu").read_bytes()
