"""Inputs of a driven joint that no host sets: the motor is held, and the controller has its stated gain."""

from __future__ import annotations

import zipfile
from functools import cache

import fmpy
import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.equations.drive import Controller, Drive
from haptid.model.equations.equations import Equations
from haptid.model.joint.locked_joint import joint_equations
from tests.fmu_build.fmu_cases import FOLDER, KINDS

GAIN, REFERENCE, ENABLED = "joint0.controller.gain", "joint0.controller.reference", "joint0.drive.enabled"
T = np.linspace(0.0, 1.0, 201)


@cache
def equations() -> Equations:
    loop = Controller(kind="pd", gain=0.4, derivative_gain=0.01, limit=0.5)
    return joint_equations(0, drive=Drive(kind="torque", controller=loop))


@cache
def built(kind: Kind) -> Fmu:
    return build_fmu(equations(), FOLDER / f"pd_{kind}.fmu", kind=kind, platforms=this_platform())


def motion(kind: Kind, **driven: float) -> np.ndarray:
    """Position [rad] along a sine of the reference, with further inputs held."""
    named = {{"gain": GAIN, "enabled": ENABLED}[key]: value for key, value in driven.items()}
    u = np.zeros(T.size, dtype=[("time", float), (REFERENCE, float), *((name, float) for name in named)])
    u["time"], u[REFERENCE] = T, 0.5 * np.sin(3.0 * T)
    for name, value in named.items():
        u[name] = value
    run = fmpy.simulate_fmu(
        str(built(kind).path), fmi_type="CoSimulation", input=u, output=["joint0.position"], stop_time=1.0,
        output_interval=0.005,
    )  # fmt: skip
    return np.asarray(run["joint0.position"])


@pytest.mark.parametrize("kind", KINDS)
def test_the_description_starts_with_the_stated_gain_and_the_motor_held(kind: Kind):
    variables = {v.name: v for v in fmpy.read_model_description(str(built(kind).path)).modelVariables}
    assert float(variables[GAIN].start) == 0.4
    assert float(variables[ENABLED].start) == 1.0
    assert float(variables[REFERENCE].start) == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_the_reference_alone_moves_the_joint_as_all_inputs_do(kind: Kind):
    alone = motion(kind)
    assert np.ptp(alone) > 0.1
    assert np.array_equal(alone, motion(kind, gain=0.4, enabled=1.0))
    assert np.ptp(motion(kind, gain=0.4, enabled=0.0)) == 0.0  # a driven input is as it was


def test_the_page_tells_what_may_be_left_alone():
    with zipfile.ZipFile(built("native").path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "An input that nothing sets keeps its start value" in page
    assert f"<code>{GAIN}</code>\n(0.4 N m/rad)" in page
    assert f"<code>{ENABLED}</code>\n(1)" in page
