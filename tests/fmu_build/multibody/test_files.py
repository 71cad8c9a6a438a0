"""URDF and MJCF as files: haptid reads its own URDF again, the command writes and refuses, losses are told."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner

from haptid.api.identified import Identified
from haptid.fmu_build.export import main as export
from haptid.fmu_build.multibody.bodies import multibody
from haptid.fmu_build.multibody.losses import losses_of_mjcf, losses_of_urdf
from haptid.fmu_build.multibody.urdf import text_of
from haptid.fmu_build.multibody.write import identified_multibody, write_multibody
from haptid.model.algebra.numeric_coordinates import Numbers
from haptid.model.device.device import Device
from haptid.model.device.reader import load_device
from haptid.model.rigid_body.composite_bodies import mass_matrix
from haptid.model.rigid_body.inertial_parameters import pi_prior
from haptid.model.rigid_body.newton_euler import inverse_dynamics
from haptid.support.errors import InputError
from tests.fmu_build.multibody.machines import NAMES, device, machine, values_of


def terms(d: Device, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrix and bias of a device without rotors, at its first guesses."""
    pi = pi_prior(d)[0]
    inertials = {link.name: tuple(pi[10 * i : 10 * i + 10]) for i, link in enumerate(d.massive)}
    zero = tuple(0.0 for _ in d.motors)
    M = np.array(mass_matrix(d, Numbers(q), inertials, zero), dtype=float)
    return M, np.array(inverse_dynamics(d, Numbers(q), inertials, dict(enumerate(v)), {}), dtype=float)


@pytest.mark.parametrize("name", NAMES)
def test_haptid_reads_its_own_urdf_as_the_same_device(name: str, tmp_path: Path):
    d = device(name)
    read = load_device(write_multibody(machine(name), tmp_path / f"{name}.urdf", "urdf").path)
    read = replace(read, gravity=d.gravity)  # the format has none
    rng = np.random.default_rng(5)
    for q, v in rng.uniform(-1, 1, (10, 2, len(d.joints))):
        for again, first in zip(terms(read, q, v), terms(d, q, v), strict=True):
            np.testing.assert_allclose(again, first, rtol=0, atol=1e-12 * np.abs(first).max())
    assert [joint.prismatic for joint in read.joints] == [joint.prismatic for joint in d.joints]
    assert [joint.position_limits for joint in read.joints] == [joint.position_limits for joint in d.joints]
    for axis, joint in zip(machine(name).axes, read.joints, strict=True):
        assert joint.parameters["sigma2"].initial == axis.viscous
        assert joint.parameters["Fc"].initial == axis.coulomb


def test_numbers_keep_their_last_bit():
    numbers = np.random.default_rng(1).normal(size=20) * 10.0 ** np.arange(-10, 10)
    assert [float(word) for word in text_of(numbers).split()] == numbers.tolist()


def result(tmp_path: Path, **changes: object) -> Path:
    values = values_of("freedom6s") | {"link6_m": 0.011, "Ks_4": 0.0123, "Fc_3": 9e-4}
    data = {
        "schema": "identification/1", "device": "freedom6s", "campaign": "a test", "measured": False,
        "configurations": [], "links": {}, "whole": values, **changes,
    }  # fmt: skip
    path = tmp_path / "identification.json"
    path.write_text(json.dumps(data))
    return path


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_the_command_writes_the_identified_values_and_says_what_is_lost(kind: str, tmp_path: Path):
    out = tmp_path / f"device.{kind}"
    done = CliRunner().invoke(export, ["--from", str(result(tmp_path)), "--out", str(out), "--kind", kind])
    assert done.exit_code == 0, done.output
    root = ElementTree.parse(out).getroot()
    if kind == "urdf":
        assert root.find("link[@name='6']/inertial/mass").get("value") == "0.011"
        assert root.find("joint[@name='joint3']/dynamics").get("friction") == "0.0009"
        assert "not carried: springs: those of joint0" in done.output
        assert [joint.get("name") for joint in root.iterfind("joint")][:6] == [f"joint{j}" for j in range(6)]
    else:
        assert root.find(".//body[@name='6']/inertial").get("mass") == "0.011"
        assert root.find(".//joint[@name='joint4']").get("stiffness") == "0.0123"
        assert root.find(".//dcmotor[@joint='joint3']").get("lugre").split()[2] == "0.0009"
    assert "SYNTHETIC" in out.read_text(encoding="utf-8")
    assert "not carried: passive links: " in done.output
    guessed = "joints 0, 1, 2, 3, 4, 5: not identified, so that the device's first guesses stand there"
    assert f"identification.json: {guessed}" in done.stderr
    assert guessed in out.read_text(encoding="utf-8")


def test_frictionloss_is_asked_for_by_an_option(tmp_path: Path):
    out = tmp_path / "device.xml"
    arguments = ["--from", str(result(tmp_path)), "--out", str(out), "--kind", "mjcf", "--friction", "frictionloss"]
    assert CliRunner().invoke(export, arguments).exit_code == 0
    root = ElementTree.parse(out).getroot()
    assert root.find(".//dcmotor") is None
    assert root.find(".//joint[@name='joint3']").get("frictionloss") == "0.0009"


@pytest.mark.parametrize(
    "more", [["--joints", "4"], ["--fmi", "3.0"], ["--effects", "x"], ["--with", "joint3.json"]], ids=lambda x: x[0]
)
def test_what_bodies_cannot_hold_is_refused_in_one_line(more: list[str], tmp_path: Path):
    out = tmp_path / "device.urdf"
    arguments = ["--from", str(result(tmp_path)), "--out", str(out), "--kind", "urdf", *more]
    done = CliRunner().invoke(export, arguments)
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
    assert more[0] in done.stderr
    assert not out.exists()


def test_a_joint_alone_has_no_bodies(tmp_path: Path):
    arguments = ["--from", str(result(tmp_path, device="single_joint")), "--out", str(tmp_path / "x"), "--kind", "mjcf"]
    done = CliRunner().invoke(export, arguments)
    assert done.exit_code == 2
    assert "a device with links" in done.stderr
    assert done.stderr.rstrip().endswith("; export an FMU: choose a name that ends in .fmu")


def test_links_that_are_no_bodies_are_refused():
    with pytest.raises(InputError, match="triangle inequality"):
        multibody(device("freedom6s"), values_of("freedom6s") | {"link4_I11": 1.0}, "")


def test_a_joint_that_no_link_follows_one_to_one_is_refused():
    d = device("odd")
    links = tuple(replace(x, moved_by={j: 2 * r for j, r in x.moved_by.items()}) for x in d.links)
    with pytest.raises(InputError, match="joint 0"):
        multibody(replace(d, links=links), values_of("odd"), "")


def test_a_joint_that_turns_no_link_by_itself_goes_into_a_urdf_but_not_into_an_mjcf(tmp_path: Path):
    d = device("odd")
    links = tuple(replace(x, moved_by={**x.moved_by, 0: Fraction(-1)}) if x.name == "b" else x for x in d.links)
    m = multibody(replace(d, links=links), values_of("odd"), "")
    assert write_multibody(m, tmp_path / "m.urdf", "urdf").path.exists()
    with pytest.raises(InputError, match="joint1"):
        write_multibody(m, tmp_path / "m.xml", "mjcf")
    assert not (tmp_path / "m.xml").exists()


def test_losses_name_what_the_device_has():
    pendulum, rod = machine("double_pendulum"), machine("freedom6s")
    assert any(sentence.startswith("rotors: ") for sentence in losses_of_urdf(pendulum))
    assert not any(sentence.startswith("rotors: ") for sentence in losses_of_urdf(rod))
    assert losses_of_mjcf(pendulum, "lugre") == ()
    assert any(sentence.startswith("friction of joint0") for sentence in losses_of_mjcf(pendulum, "frictionloss"))
    dahl = replace(rod, axes=(replace(rod.axes[0], friction="dahl"), *rod.axes[1:]))
    assert any(sentence.startswith("friction of joint0:") for sentence in losses_of_mjcf(dahl, "lugre"))
    gained = replace(rod, axes=(replace(rod.axes[0], gain=1.1), *rod.axes[1:]))
    assert any(sentence.startswith("gains: Kp of joint0") for sentence in losses_of_urdf(gained))


def test_python_writes_what_the_command_writes(tmp_path: Path):
    out = tmp_path / "command.xml"
    source = result(tmp_path)
    assert CliRunner().invoke(export, ["--from", str(source), "--out", str(out), "--kind", "mjcf"]).exit_code == 0
    identified = Identified.read(tmp_path)
    losses = identified.export_bodies(tmp_path / "api.xml")
    assert (tmp_path / "api.xml").read_bytes() == out.read_bytes()
    assert losses == losses_of_mjcf(identified_multibody(device("freedom6s"), json.loads(source.read_text())), "lugre")
