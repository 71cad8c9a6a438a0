"""The FMU run by fmpy and the compiled loop, against the kernel in process."""

from __future__ import annotations

import pickle
from functools import cache
from zipfile import ZipFile

import numpy as np
import pytest

from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Kind, build_fmu
from haptid.fmu_build.native.platforms import this_platform
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.signals.averaging import average_rows
from haptid.measurement.values.run import Run
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.support.errors import NumericalError

T = 0.005 * np.arange(301)


@cache
def equations(*joints: int) -> Equations:
    return configuration_equations(load_device("freedom6s"), joints)


@cache
def simulators(kind: Kind, *joints: int) -> tuple[FmuSimulator, KernelSimulator]:
    e = equations(*joints)
    return FmuSimulator.of(identification_fmu(e, kind=kind), e), KernelSimulator.of(e)


def run_of(n: int, hold: str = "zero", t: np.ndarray = T) -> Run:
    u = np.column_stack([4e-3 * np.cos((2 + j) * t) for j in range(n)])
    y = np.column_stack([0.05 * np.sin((2 + j) * t) for j in range(n)])
    return Run(
        file="run",
        free_joints=tuple(range(n)),
        t=t,
        u=u,
        y=y,
        noise=np.full(n, 2e-4),
        resolution=np.zeros(n),
        posture=[],
        use="fit",
        hold=hold,
    )


def initial(e: Equations) -> np.ndarray:
    return np.array([q.initial for q in e.parameters])


@pytest.mark.parametrize("gain", [0.0, 20.0])
@pytest.mark.parametrize("hold", ["zero", "linear"])
@pytest.mark.parametrize("joints", [(4,), (0, 1)])
@pytest.mark.parametrize("kind", ["python", "native"])
def test_trajectory_and_sensitivities_equal_the_kernels(kind: Kind, joints, hold, gain):
    fmu, kernel = simulators(kind, *joints)
    run, theta = run_of(len(joints), hold), initial(equations(*joints))
    a, b = (s.simulate(theta, run, gain=gain, sensitivities=True) for s in (fmu, kernel))
    scale = np.abs(b.dy_dtheta).max()
    np.testing.assert_allclose(a.y, b.y, rtol=0, atol=1e-13)
    np.testing.assert_allclose(a.dy_dtheta, b.dy_dtheta, rtol=1e-9, atol=1e-12 * scale)
    np.testing.assert_allclose(a.dy_dx0, b.dy_dx0, rtol=1e-9, atol=1e-12 * scale)
    plain = fmu.simulate(theta, run, gain=gain)
    assert plain.dy_dtheta is None
    np.testing.assert_allclose(plain.y, b.y, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", ["python", "native"])
def test_uneven_rows_and_a_given_initial_state(kind: Kind):
    fmu, kernel = simulators(kind, 4)
    t = np.cumsum(np.random.default_rng(0).uniform(1e-3, 9e-3, 200))
    run, theta, x0 = run_of(1, t=t - t[0]), initial(equations(4)), np.array([0.02, -0.1, 1e-4])
    np.testing.assert_allclose(
        fmu.simulate(theta, run, x0=x0).y, kernel.simulate(theta, run, x0=x0).y, rtol=0, atol=1e-13
    )


def test_calls_leave_no_trace():
    fmu, _ = simulators("python", 4)
    run, theta = run_of(1), initial(equations(4))
    first = fmu.simulate(theta, run).y
    fmu.simulate(theta * 1.1, run, gain=20.0, sensitivities=True)
    np.testing.assert_array_equal(fmu.simulate(theta, run).y, first)


def test_satisfies_the_protocol_and_crosses_processes():
    fmu, kernel = simulators("python", 4)
    simulator: Simulator = pickle.loads(pickle.dumps(fmu))
    theta = initial(equations(4))
    np.testing.assert_allclose(simulator.simulate(theta, run_of(1)).y, kernel.simulate(theta, run_of(1)).y, atol=1e-13)


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_state_that_runs_away_gives_nan_from_there_on(kind: Kind):
    fmu, _ = simulators(kind, 4)
    y = fmu.simulate(initial(equations(4)), run_of(1), x0=np.array([0.0, 1e300, 0.0])).y
    assert np.isfinite(y[0]).all()
    assert np.isnan(y[-1]).all()


@pytest.mark.parametrize("kind", ["python", "native"])
def test_bad_parameters_are_an_error_that_names_them(kind: Kind):
    fmu, _ = simulators(kind, 4)
    theta = initial(equations(4))
    theta[0] = np.nan
    with pytest.raises(NumericalError, match="inertia"):
        fmu.simulate(theta, run_of(1))


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_negative_inertia_never_passes_for_a_trajectory(kind: Kind):
    theta = initial(equations(4))
    theta[0] = -1e-4
    with pytest.raises(NumericalError, match="inertia"):
        simulators(kind, 4)[0].simulate(theta, run_of(1))


def test_bounds_of_the_first_guess_do_not_bind_a_fit():
    fmu, kernel = simulators("native", 4)
    e = equations(4)
    theta = initial(e)
    index = [q.id for q in e.parameters].index("Fs")
    theta[index] = 0.5 * theta[index + 1]
    np.testing.assert_allclose(fmu.simulate(theta, run_of(1)).y, kernel.simulate(theta, run_of(1)).y, atol=1e-13)


def test_a_shipped_fmu_is_refused(tmp_path):
    built = build_fmu(equations(4), tmp_path / "plain.fmu", platforms=())
    with pytest.raises(ValueError, match="identification=True"):
        FmuSimulator.of(built, equations(4))


def test_an_identification_fmu_holds_loaders_for_this_machine_alone():
    names = ZipFile(identification_fmu(equations(4)).path).namelist()
    folders = {name.split("/")[1] for name in names if name.startswith("binaries/") and not name.endswith("/")}
    assert folders <= {p.fmi2[0] for p in this_platform()}


@pytest.mark.parametrize("kind", ["python", "native"])
def test_a_simulation_is_averaged_over_rows_as_the_recorder_did(kind: Kind):
    run, theta = run_of(1), initial(equations(4))
    for simulator in simulators(kind, 4):
        plain = simulator.simulate(theta, run, sensitivities=True)
        made = simulator.simulate(theta, run.but(averaged_rows=5), sensitivities=True)
        for now, before in ((made.y, plain.y), (made.dy_dtheta, plain.dy_dtheta), (made.dy_dx0, plain.dy_dx0)):
            np.testing.assert_array_equal(now, average_rows(before, 5))
        np.testing.assert_array_equal(simulator.simulate(theta, run.but(averaged_rows=5)).y, average_rows(plain.y, 5))
    kernel = simulators(kind, 4)[1]
    many = kernel.simulate_many(np.stack([theta, 1.1 * theta]), run.but(averaged_rows=5))
    np.testing.assert_allclose(many[0], average_rows(kernel.simulate(theta, run).y, 5), rtol=0, atol=1e-12)
