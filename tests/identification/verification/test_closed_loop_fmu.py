"""The controller as an FMU beside the device's FMU: the same torques and motion as the law applied row by row."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.identification.simulators.closed_loop import Controller, reference_of, simulate_closed_loop
from haptid.identification.simulators.controller_equations import controller_equations
from haptid.identification.verification.closed_loop_fmu import Pair, build_controller, simulate_pair
from haptid.measurement.format.embedded import embedded_campaign
from haptid.measurement.format.reading import read_campaign
from haptid.measurement.values.run import Run
from haptid.model.device.reader import load_device
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel

ROWS = 301


@pytest.fixture(scope="module")
def run() -> Run:
    whole = read_campaign(embedded_campaign("paper")).runs_of((0, 1, 2, 3, 4, 5))[0]
    extra = {name: column[:ROWS] for name, column in whole.extra.items()}
    return whole.but(t=whole.t[:ROWS], u=whole.u[:ROWS], y=whole.y[:ROWS], extra=extra)


@pytest.fixture(scope="module")
def controller() -> Controller:
    return Controller.from_table(read_campaign(embedded_campaign("paper")).extra["controller"], 6)


def test_equations_give_the_recorded_torques(run: Run, controller: Controller) -> None:
    """The recorded torques are the law applied to the recorded readings, rounded to 8 digits."""
    reference = reference_of(run)
    assert reference is not None
    equations = controller_equations(controller, 0.005, run.free_joints)
    inputs = np.column_stack([reference, run.y])
    theta = np.array([q.initial for q in equations.parameters])
    torque = CompiledKernel.of(equations).simulate(run.t, inputs, theta, run.y[0])
    assert np.max(np.abs(torque - run.u)) < 1e-6
    assert np.std(run.u) > 1e-3


@pytest.mark.parametrize("kind", ["python", "native"])
def test_pair_of_fmus_moves_as_the_law_in_process(run: Run, controller: Controller, kind: Kind, tmp_path: Path) -> None:
    equations, reference = full_equations(load_device("freedom6s")), reference_of(run)
    assert reference is not None
    pair = Pair(
        device=build_fmu(equations, tmp_path / "device.fmu", kind=kind, platforms=this_platform()),
        controller=build_controller(controller, run, tmp_path / "law.fmu", kind=kind, platforms=this_platform()),
    )
    theta = np.array([q.initial for q in equations.parameters])
    y, torque = simulate_closed_loop(CompiledKernel.of(equations), theta, run, controller, reference)
    y_fmu, torque_fmu = simulate_pair(pair, run, reference)
    assert np.max(np.abs(y_fmu - y)) < 1e-10
    assert np.max(np.abs(torque_fmu - torque)) < 1e-10
    system = pair.write_system(tmp_path / "closed_loop.ssp", stop_time=1.5)
    with zipfile.ZipFile(system) as archive:
        text = archive.read("SystemStructure.ssd").decode()
        bound = {name: archive.read(f"resources/{name}.ssv").decode() for name in ("device", "controller")}
    assert text.count("<ssd:Connection ") == 12
    assert 'startConnector="joint3.controller.torque"' in text
    for name, values in bound.items():
        assert f'<ssd:ParameterBinding source="resources/{name}.ssv"' in text
        parameters = getattr(pair, name).equations.parameters
        assert values.count("<ssv:Parameter ") == len(parameters) > 0


def test_no_filter_is_the_plain_difference() -> None:
    law = Controller(proportional=np.array([2.0]), derivative=np.array([0.1]), filter_s=0.0)
    equations = controller_equations(law, 0.01, (0,))
    t, y = 0.01 * np.arange(5), np.array([0.0, 0.1, 0.3, 0.2, 0.2])
    theta = np.array([q.initial for q in equations.parameters])
    made = CompiledKernel.of(equations).simulate(t, np.column_stack([np.ones(5), y]), theta, [0.0])[:, 0]
    expected = 2.0 * (1.0 - y) - 0.1 * np.diff(y, prepend=0.0) / 0.01
    assert made == pytest.approx(expected, abs=1e-5)
