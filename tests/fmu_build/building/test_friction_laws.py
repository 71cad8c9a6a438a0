"""FMUs of joints after each friction law, against an independent integration; the whole device with several laws."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel
from haptid.virtual_device.machine.arm import Arm
from haptid.virtual_device.machine.truth import read_truth
from tests.fmu_build.fmu_cases import FOLDER, KINDS, Client, initial, torques
from tests.identification.verification.test_verification import true_values
from tests.model.friction.test_friction_laws import mixed
from tests.model.friction_cases import AMPLITUDE, JOINT, radau

T = 0.005 * np.arange(161)
LAWS = {"coulomb": 2e-5, "dahl": 3e-7, "maxwell_slip": 2e-5}
"""Largest distance from Radau [rad] at the standard step."""


@cache
def joint(law: str) -> Equations:
    e = joint_equations(4, friction=law)
    return e.with_parameters({q.id: {"initial": JOINT[q.id]} for q in e.parameters})


@cache
def joint_fmu(law: str, kind: Kind) -> Fmu:
    return build_fmu(joint(law), FOLDER / f"{law}_{kind}.fmu", kind=kind, platforms=this_platform())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
def test_an_fmu_agrees_with_radau(law: str, kind: Kind):
    u = AMPLITUDE * (0.8 * np.cos(2.4 * T) + 0.4 * np.cos(11.0 * T + 1.0))
    got = Client(joint_fmu(law, kind)).start().go().run(joint(law), T, u[:, None])[:, 0]
    expected = radau(law, JOINT, T, u)
    assert np.ptp(expected) > 0.1
    np.testing.assert_allclose(got, expected, rtol=0, atol=LAWS[law])


@pytest.mark.parametrize("law", LAWS)
def test_the_archive_is_valid_and_its_page_shows_the_law(law: str):
    path = joint_fmu(law, "native").path
    assert not fmpy.validation.validate_fmu(str(path))
    names = {v.name for v in fmpy.read_model_description(str(path)).modelVariables}
    inner = {"coulomb": "vc", "dahl": "bristle", "maxwell_slip": "element4"}[law]
    assert {f"joint4.friction.{inner}", "joint4.friction.Fc"} <= names
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "joint4.friction.sigma2" in page


@pytest.mark.parametrize("kind", KINDS)
def test_the_whole_device_with_several_laws_builds_and_simulates(kind: Kind, tmp_path: Path):
    e = full_equations(mixed())
    fmu = build_fmu(e, tmp_path / "mixed.fmu", kind=kind, platforms=this_platform())
    u = torques(e, T)
    got = Client(fmu).start().go().run(e, T, u)
    expected = CompiledKernel.of(e, many=False).simulate(T, u, initial(e), np.zeros(len(e.states)))
    np.testing.assert_array_equal(got, expected)
    with zipfile.ZipFile(fmu.path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "LuGre friction of joints 0, 1, 2, 3: σ0·z + σ1·ż + σ2·v" in page
    assert "Dahl friction of joint 4: σ0·z + σ2·v" in page
    assert "Generalised Maxwell-slip friction of joint 5" in page


@pytest.mark.parametrize(("law", "most"), [("dahl", LAWS["dahl"]), ("maxwell_slip", 7e-5)])
def test_the_whole_device_with_several_laws_moves_as_the_independent_arm(law: str, most: float, tmp_path: Path):
    """Elements of the arm jump from stick to slip, those of the FMU do not: a third of a sensor's noise apart."""
    laws = {2: "dahl", 4: law}
    true = replace(read_truth(), friction=laws)
    values, e = true_values(true), full_equations(load_device("freedom6s").with_friction(laws))
    e = e.with_parameters({q.id: {"initial": values[q.id]} for q in e.parameters if not q.fixed})
    fmu = build_fmu(e, tmp_path / "mixed.fmu", kind="native", platforms=this_platform())
    u, arm, joints = torques(e, T), Arm(true), tuple(range(6))
    got = Client(fmu).start().go().run(e, T, u)[:, :6]
    state, expected = arm.start(np.zeros(6)), []
    for row in u[:, :6]:
        expected.append(state[:6].copy())
        arm.advance(joints, state, row, 0.005, max_step=2.5e-5)
    assert np.all(np.ptp(expected, axis=0)[[2, 4]] > 0.1)
    np.testing.assert_allclose(got, expected, rtol=0, atol=most)


def test_two_joints_with_different_laws_have_an_fmu(tmp_path: Path):
    e = configuration_equations(mixed(), [4, 5])
    fmu = build_fmu(e, tmp_path / "pair.fmu", kind="native", platforms=this_platform())
    u = torques(e, T)
    expected = CompiledKernel.of(e, many=False, tangent=False).simulate(T, u, initial(e), np.zeros(len(e.states)))
    np.testing.assert_allclose(Client(fmu).start().go().run(e, T, u), expected, rtol=0, atol=1e-12)
