"""The two commands: FMUs of all configurations, export of an identified model."""

from __future__ import annotations

import json
from pathlib import Path

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner

from haptid.fmu_build.building import configurations as module
from haptid.fmu_build.building.packaging import build_fmu
from haptid.fmu_build.export import export_full, export_parameters
from haptid.fmu_build.export import main as export
from haptid.fmu_build.native.platforms import this_platform
from haptid.fmu_build.run import main as run
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from tests.fmu_build.fmu_cases import DEVICE, STEP, Client, equations, initial, kernel, torques


def identification() -> dict:
    parameter = {"value": 0.0123, "std": 1e-5, "unit": "N m/rad", "status": "identified"}
    inertia = {"value": 1.3e-4, "std": 1e-6, "unit": "kg m^2", "status": "identified"}
    rest = {
        q.id: {"value": q.initial, "std": None, "unit": q.unit, "status": "prior"}
        for q in equations("joint4").parameters
    }
    return {
        "schema": "identification/1",
        "device": "freedom6s",
        "campaign": "a test",
        "measured": False,
        "configurations": [{"free_joints": [4], "parameters": {**rest, "Ks": parameter, "inertia": inertia}}],
        "links": {"6": {"m": {"value": 0.11, "std": 0.01, "unit": "kg", "status": "identified"}}},
    }


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "identification.json"
    path.write_text(json.dumps(identification()))
    return path


@pytest.fixture(autouse=True)
def here_only(monkeypatch, tmp_path):
    """Binaries for this machine alone, and a cache of the test's own."""
    monkeypatch.setattr("haptid.fmu_build.building.packaging.PLATFORMS", this_platform())
    return tmp_path


def test_configurations_follow_the_joints_asked_for():
    assert module.configurations(DEVICE) == ((0,), (1,), (2,), (3,), (4,), (5,), (0, 1))
    assert module.configurations(DEVICE, [4, 3]) == ((3,), (4,))


def test_run_builds_and_then_copies(tmp_path):
    first = CliRunner().invoke(run, ["--joints", "4,5", "--out", str(tmp_path), "--quiet"])
    assert first.exit_code == 0, first.output
    built = sorted(path.name for path in (tmp_path / "fmu").iterdir())
    assert built == ["joint4.fmu", "joint5.fmu"]
    content = (tmp_path / "fmu" / "joint4.fmu").read_bytes()
    CliRunner().invoke(run, ["--joints", "4", "--out", str(tmp_path), "--quiet"])
    assert (tmp_path / "fmu" / "joint4.fmu").read_bytes() == content


@pytest.mark.parametrize("arguments", [["--joints", "9"], ["--joints", "x"], ["no_such_device"]])
def test_run_refuses_bad_input_in_one_line(arguments, tmp_path):
    result = CliRunner().invoke(run, [*arguments, "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["python", "native"])
def test_export_puts_the_identified_values_into_the_whole_device(kind, source, tmp_path):
    out = tmp_path / f"{kind}.fmu"
    result = CliRunner().invoke(export, ["--from", str(source), "--out", str(out), "--kind", kind])
    assert result.exit_code == 0, result.output
    variables = {v.name: v for v in fmpy.read_model_description(str(out)).modelVariables}
    assert float(variables["joint4.spring.Ks"].start) == 0.0123
    assert float(variables["link6.m"].start) == 0.11
    e = equations("freedom6s")
    ids, p, t = [q.id for q in e.parameters], initial(e), STEP * np.arange(41)
    p[ids.index("Ks_4")], p[ids.index("link6_m")] = 0.0123, 0.11
    got = Client(out).start().go().run(e, t, torques(e, t))
    np.testing.assert_array_equal(got, kernel("freedom6s").simulate(t, torques(e, t), p, np.zeros(18)))


@pytest.mark.usefixtures("source")
def test_the_folder_of_a_result_stands_for_its_file(tmp_path):
    out = tmp_path / "joint.fmu"
    done = CliRunner().invoke(export, ["--from", str(tmp_path), "--out", str(out), "--joints", "4"])
    assert done.exit_code == 0, done.output
    assert out.exists()
    (tmp_path / "empty").mkdir()
    done = CliRunner().invoke(export, ["--from", str(tmp_path / "empty"), "--out", str(out)])
    assert f"{Path('empty', 'identification.json')}: expected an identification.json that can be read" in done.stderr


@pytest.mark.parametrize("name", ["arm.urdf", "arm.xml"])
def test_the_name_says_that_bodies_are_wanted(name, source, tmp_path):
    """It was refused as a name of no FMU, without a word on --kind."""
    out = tmp_path / name
    done = CliRunner().invoke(export, ["--from", str(source), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert ("<robot" if name == "arm.urdf" else "<mujoco") in out.read_text()
    done = CliRunner().invoke(export, ["--from", str(source), "--out", str(out), "--kind", "native"])
    assert done.exit_code == 2
    assert f"state --kind {'urdf' if name == 'arm.urdf' else 'mjcf'}, or choose a name that ends in .fmu" in done.stderr


def test_bodies_are_not_written_into_a_file_that_is_named_as_an_fmu(source, tmp_path):
    done = CliRunner().invoke(export, ["--from", str(source), "--out", str(tmp_path / "x.fmu"), "--kind", "urdf"])
    assert done.exit_code == 2
    assert "expected --kind python or native for a name that ends in .fmu, got --kind urdf" in done.stderr


def test_export_in_fmi_3(source, tmp_path):
    out = tmp_path / "whole.fmu"
    arguments = ["--from", str(source), "--out", str(out), "--fmi", "3.0", "--kind"]
    result = CliRunner().invoke(export, [*arguments, "native"])
    assert result.exit_code == 0, result.output
    assert "FMI 3.0" in result.stdout
    description = fmpy.read_model_description(str(out))
    assert description.fmiVersion == "3.0"
    assert {v.name: v.start for v in description.modelVariables}["joint4.spring.Ks"] == "0.0123"
    out.unlink()
    result = CliRunner().invoke(export, [*arguments, "python"])
    assert result.exit_code == 2
    assert "expected --kind native" in result.stderr
    assert not out.exists()


def test_export_of_one_joint(source, tmp_path):
    out = tmp_path / "joint.fmu"
    result = CliRunner().invoke(export, ["--from", str(source), "--out", str(out), "--joints", "4"])
    assert result.exit_code == 0, result.output
    variables = {v.name: v for v in fmpy.read_model_description(str(out)).modelVariables}
    assert float(variables["joint4.inertia"].start) == 1.3e-4


def test_the_documentation_shows_where_values_come_from(tmp_path):
    import zipfile  # noqa: PLC0415 # this test alone

    built = export_full(DEVICE, identification(), tmp_path / "whole.fmu", "native")
    with zipfile.ZipFile(built.path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "test of joint 4, a test (SYNTHETIC data)" in page
    assert "± 1e-05" in page
    assert "first guess" in page


def test_the_parameter_set_names_the_fmus_variables(tmp_path):
    text = export_parameters(DEVICE, identification(), tmp_path / "parameters.ssv").read_text()
    assert 'name="joint4.spring.Ks"' in text
    assert 'value="0.0123" unit="N m/rad"' in text


@pytest.mark.parametrize("content", ["{", "[]", '{"schema": "other/1"}', None])
def test_export_refuses_what_is_no_identification(content, tmp_path):
    path = tmp_path / "identification.json"
    if content is not None:
        path.write_text(content)
    result = CliRunner().invoke(export, ["--from", str(path), "--out", str(tmp_path / "x.fmu")])
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "x.fmu").exists()


@pytest.mark.parametrize("name", ["x.txt", "x", "x.fmu.zip"])
def test_an_fmu_of_another_name_is_refused(name: str, tmp_path):
    path = tmp_path / "identification.json"
    path.write_text(json.dumps(identification()))
    result = CliRunner().invoke(export, ["--from", str(path), "--out", str(tmp_path / name)])
    assert result.exit_code == 2
    assert f"{name}: expected a name that ends in .fmu, got {name!r}; call the FMU x" in result.stderr
    assert not (tmp_path / name).exists()


def test_links_that_no_body_has_are_told(tmp_path):
    path, data = tmp_path / "identification.json", identification()
    data["links"]["6"]["I11"] = {"value": 0.01, "unit": "kg m^2"}
    path.write_text(json.dumps(data))
    arguments = ["--from", str(path), "--out", str(tmp_path / "x.fmu"), "--kind", "native"]
    assert "identification.json: link 6: no body has this inertia" in CliRunner().invoke(export, arguments).stderr


def test_a_model_whose_reference_run_overflows_is_refused(tmp_path):
    e = joint_equations(4)
    with pytest.raises(InputError, match=r"expected finite outputs of the reference run.*joint4\.spring\.Ks = 1e\+300"):
        build_fmu(e, tmp_path / "x.fmu", kind="native", values={"Ks": 1e300})
    assert not list(tmp_path.iterdir())
    path, data = tmp_path / "identification.json", identification()
    data["links"]["6"]["I12"] = {"value": 1.0, "unit": "kg m^2"}
    path.write_text(json.dumps(data))
    done = CliRunner().invoke(export, ["--from", str(path), "--out", str(tmp_path / "x.fmu"), "--kind", "native"])
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {path}: ")
    assert "no body has this inertia" in line
    assert not (tmp_path / "x.fmu").exists()


def test_joints_that_were_not_identified_are_told(tmp_path):
    """The FMU of a device of which joint 4 alone was identified was exported without a word."""
    path = tmp_path / "identification.json"
    path.write_text(json.dumps(identification()))
    tested = {joint for entry in identification()["configurations"] for joint in entry["free_joints"]}
    done = CliRunner().invoke(export, ["--from", str(path), "--out", str(tmp_path / "x.fmu"), "--kind", "native"])
    assert done.exit_code == 0
    others = ", ".join(str(joint) for joint in range(6) if joint not in tested)
    first = f"joints {others}: not identified, so that the device's first guesses stand there"
    assert f"identification.json: {first}; --joints {min(tested)} packages an identified joint alone" in done.stderr
