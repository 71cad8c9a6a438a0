"""A joint after each friction law, made by the independent device, identified to the noise by the usual commands."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.fmu_build.exchange.identification_json import friction_by_joint, read_identification
from haptid.fmu_build.export import export_full
from haptid.fmu_build.export import main as export
from haptid.identification.run import main
from haptid.identification.simulators.inverse_dynamics import TorqueSimulator, torque_equations, torque_run
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.statistics.excitation_warnings import excitation_warnings
from haptid.measurement.values.run import Run
from haptid.model.device.reader import load_device
from haptid.model.joint.locked_joint import joint_equations
from haptid.support.errors import InputError
from haptid.virtual_device.recording.campaign import make_joint_campaign
from haptid.virtual_device.recording.inputs import Cosine
from haptid.virtual_device.recording.sensor import Sensor
from haptid.virtual_device.stranger.campaign import make_stranger_campaign, stranger_runs
from haptid.virtual_device.stranger.readings import Recorder
from tests.identification.bench_joint import TRUE
from tests.model.friction_cases import JOINT

LAWS = ("coulomb", "dahl", "maxwell_slip")
OF_LAW = {"coulomb": {"vc": 0.01}, "dahl": {"n": 1.4}, "maxwell_slip": {"C": 0.04, "spread": 2.0, "unevenness": 0.8}}
FAST = ("--quiet", "--workers", "1", "--fmu", "none", "--method", "gauss_newton", "--no-export")
COSINES = (
    Cosine(amplitude=0.005, frequency=1.13, duration=6.0),
    Cosine(amplitude=0.004, frequency=2.4, duration=6.0),
    Cosine(amplitude=0.0045, frequency=1.75, duration=6.0, use="validate"),
)


def make(folder: Path, law: str, **more: object) -> Path:
    if law == "coulomb":
        return make_without_states(folder)
    truth, sensor = {**TRUE, "Kp": 1.0, **OF_LAW[law]}, Sensor(noise=2e-4, resolution=1.5e-4)
    make_joint_campaign(folder, 4, truth, COSINES, sensor=sensor, seed=4, friction=law, **more)  # type: ignore[arg-type]
    return folder


def make_without_states(folder: Path) -> Path:
    """Make a joint of the stranger, whose friction is a function of speed alone; its Stribeck curve is flat."""
    joint = {**TRUE, "Kp": 1.0, "law": "static", "creep": OF_LAW["coulomb"]["vc"], "Fs": TRUE["Fc"]}
    runs = stranger_runs(4, joint, COSINES, Recorder(white=2e-4, resolution=1.5e-4), seed=4)
    toml = make_stranger_campaign(folder, 4, runs, device="single_joint", known={}, noise={"noise_rad": 2e-4})
    toml.write_text(toml.read_text() + '\n[joint.4]\nfriction = "coulomb"\n')
    return folder


@pytest.fixture(scope="module", params=LAWS)
def identified(request, tmp_path_factory):
    law = request.param
    folder = make(tmp_path_factory.mktemp("campaign"), law)
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder / "out"), *FAST])
    assert done.exit_code == 0, done.output
    return law, folder / "out" / "identification.json"


@pytest.mark.long
def test_from_the_data_alone_the_fit_reaches_the_noise(identified):
    law, path = identified
    (one,) = json.loads(path.read_text())["configurations"]
    assert one["friction"] == law
    assert one["outcome"] == "converged"
    assert all(r["rmse_over_noise"] < 1.1 for r in one["runs"])
    open_ones = {"vs", "Fs"} if law == "coulomb" else set()  # a flat Stribeck curve leaves them open
    for id, value in {**TRUE, **OF_LAW[law]}.items():
        if id not in open_ones and id in one["parameters"]:
            entry = one["parameters"][id]
            assert abs(entry["value"] - value) < max(4 * entry["std"], 0.02 * abs(value)), id


@pytest.mark.long
def test_what_was_identified_is_exported_with_its_law(identified, tmp_path: Path):
    law, path = identified
    out = tmp_path / "joint.fmu"
    done = CliRunner().invoke(export, ["--from", str(path), "--out", str(out), "--kind", "native"])
    assert done.exit_code == 0, done.output
    assert out.is_file()
    assert friction_by_joint(read_identification(path)) == {4: law}


@pytest.mark.long
def test_a_joint_of_a_device_takes_the_law_of_its_campaign(tmp_path: Path):
    """The device's file says LuGre; the campaign, and then identification.json, say Dahl."""
    folder = make(tmp_path, "dahl", device="freedom6s")
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder), *FAST])
    assert done.exit_code == 0, done.output
    data = read_identification(folder / "identification.json")
    assert {r["use"]: r["rmse_over_noise"] < 1.1 for r in data["configurations"][0]["runs"]} == {
        "fit": True,
        "validate": True,
    }
    fmu = export_full(load_device("freedom6s"), data, folder / "whole.fmu", "native")
    assert fmu.equations.friction == ("lugre",) * 4 + ("dahl", "lugre")
    assert not any(q.id in ("vs_4", "Fs_4", "sigma1_4") for q in fmu.equations.parameters)


@pytest.mark.long
def test_results_with_another_laws_parameters_are_refused(identified, tmp_path: Path):
    _, path = identified
    data = json.loads(path.read_text())
    data["configurations"][0]["friction"] = "dry"
    (tmp_path / "a.json").write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"configurations\[0\]: friction: expected a friction law"):
        read_identification(tmp_path / "a.json")
    data["configurations"][0]["friction"] = "lugre"
    data["configurations"][0]["parameters"]["spread"] = {"value": 2.0}
    (tmp_path / "a.json").write_text(json.dumps(data))
    with pytest.raises(InputError, match=r"parameters of a locked joint, got '(spread|C|n)'"):
        read_identification(tmp_path / "a.json")


def test_a_parameter_that_the_law_lacks_is_refused(tmp_path: Path):
    folder = make(tmp_path, "dahl", known={"vs": {"initial": 0.1}})
    done = CliRunner().invoke(main, [str(folder), "--out", str(folder), *FAST])
    assert done.exit_code == 2
    assert "joint.4.parameters.vs: expected a parameter of a joint" in done.output


@pytest.mark.parametrize("law", ["lugre", *LAWS])
def test_motion_gives_the_torque_that_made_it(law: str):
    """Read from motion to torque, the equation returns the torque of a smooth run, whatever the law."""
    e = joint_equations(4, friction=law)
    theta = np.array([JOINT[q.id] for q in e.parameters])
    t = np.arange(1601) * 0.005
    u = 0.005 * np.cos(1.1 * t)
    run = Run(
        file="a.csv", free_joints=(4,), t=t, u=u[:, None], y=np.zeros((t.size, 1)), noise=np.array([1e-6]),
        resolution=np.zeros(1), posture=np.zeros(0), use="fit", prismatic=(False,), hold="linear",
    )  # fmt: skip
    y = KernelSimulator.of(e).simulate(theta, run, x0=np.zeros(len(e.states))).y
    inverse = torque_equations(e)
    assert len(inverse.states) == len(e.states) - 2
    turned = torque_run(run.but(y=y))
    found = TorqueSimulator.of_torque(inverse).simulate(theta, turned).y[:, 0]
    middle = slice(200, -100)
    assert np.sqrt(np.mean((found - turned.y[:, 0])[middle] ** 2)) < 0.02 * np.std(u)


@pytest.mark.parametrize(
    ("law", "ids"), [("dahl", "sigma0 and n stay open"), ("maxwell_slip", "sigma0, spread and unevenness stay open")]
)
def test_warnings_name_the_laws_own_parameters(law: str, ids: str):
    e = joint_equations(4, friction=law)
    theta = np.array([JOINT[q.id] for q in e.parameters])
    t = np.linspace(0.0, 10.0, 2001)
    (said,) = excitation_warnings(e, theta, [(t, 5.0 * t[:, None])])
    assert ids in said
