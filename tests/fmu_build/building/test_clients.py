"""Simulators that are not ours load the FMUs and get the kernel's samples: fmpy, libcosim, ecos, its command line."""

from __future__ import annotations

import ctypes
import importlib.metadata
import os
import shutil
import subprocess
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.simulation import simulate_fmu
from fmpy.util import read_csv

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.exchange.ssp import Connection, write_ssp
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.kernel.compiled import CompiledKernel
from tests.fmu_build.controller import controller
from tests.fmu_build.fmu_cases import KINDS, STEP, advanced, equations, fmu, initial, kernel, names, torques

ROWS = 201
T = STEP * np.arange(ROWS)
LINUX_X86 = bool(this_platform()) and this_platform()[0].python == "linux-x86_64"
needs_clients = pytest.mark.skipif(not LINUX_X86, reason="libcosimpy and ecospy come for Linux and Windows x86-64")
ROUNDING = 1e-12  # the clients build times up from steps, the kernel takes those of the rows


def expected(name: str) -> np.ndarray:
    e = equations(name)
    return kernel(name).simulate(T, torques(e, T), initial(e), np.zeros(len(e.states)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["joint4", "joints01", "freedom6s"])
def test_fmpy(name: str, kind: Kind):
    e = equations(name)
    inputs = names(e, e.inputs)
    signals = np.zeros(ROWS, dtype=[("time", "f8"), *((x, "f8") for x in inputs)])
    signals["time"] = T
    for column, values in zip(inputs, torques(e, T).T, strict=True):
        signals[column] = values
    result = simulate_fmu(
        str(fmu(name, kind).path),
        input=signals,
        output=names(e, e.outputs),
        stop_time=T[-1],
        output_interval=STEP,
        use_event_mode=False,
    )
    got = np.column_stack([result[x] for x in names(e, e.outputs)])
    # at a row fmpy reads outputs before it sets that row's inputs: outputs that use inputs differ there
    through = [o.expression.free_symbols & {u.symbol for u in e.inputs} for o in e.outputs]
    columns = [i for i, uses in enumerate(through) if not uses]
    np.testing.assert_allclose(got[:ROWS, columns], expected(name)[:, columns], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("kind", [*KINDS, "native3"])
@pytest.mark.parametrize("name", ["joint4", "joints01", "freedom6s"])
def test_fmpy_reproduces_every_column_of_the_reference_run(name: str, kind: Kind, tmp_path: Path):
    built = fmu(name, kind)
    with ZipFile(built.path) as archive:
        for suffix in ("in.csv", "ref.csv", "ref.opt"):
            (tmp_path / suffix).write_bytes(archive.read(f"documentation/{name}_{suffix}"))
    rows = (line.split(",") for line in (tmp_path / "ref.opt").read_text().splitlines())
    options = {key: float(value) for key, value in rows}
    reference = np.genfromtxt(tmp_path / "ref.csv", delimiter=",", names=True, deletechars="", replace_space="")
    columns = [column.strip('"') for column in (tmp_path / "ref.csv").read_text().splitlines()[0].split(",")]
    result = simulate_fmu(
        str(built.path),
        input=read_csv(str(tmp_path / "in.csv")),
        output=columns[1:],
        start_time=options["StartTime"],
        stop_time=options["StopTime"],
        step_size=options["StepSize"],
        output_interval=options["StepSize"],
        fmi_type="CoSimulation",
        use_event_mode=False,
    )
    assert set(columns[1:]) == set(names(equations(name), equations(name).outputs))
    for column, of_reference in zip(columns, reference.dtype.names, strict=True):
        np.testing.assert_allclose(result[column], reference[of_reference], rtol=0, atol=1e-9, err_msg=column)


@needs_clients
@pytest.mark.alone
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["joint4", "freedom6s"])
def test_libcosim(name: str, kind: Kind):
    execution, observer, manipulator, index = _cosim(fmu(name, kind))
    e = equations(name)
    references = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    inputs, outputs = ([references[x] for x in names(e, q)] for q in (e.inputs, e.outputs))
    u, got = torques(e, T), []
    for row in u[:-1]:
        manipulator.slave_real_values(index, inputs, list(row))
        execution.step()
        got.append(observer.last_real_values(index, outputs))
    through = [bool(o.expression.free_symbols & {x.symbol for x in e.inputs}) for o in e.outputs]
    columns = [i for i, uses in enumerate(through) if not uses]
    np.testing.assert_allclose(np.array(got)[:, columns], expected(name)[1:, columns], rtol=0, atol=ROUNDING)


def _quiet_cosim() -> None:
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415 # only where it is published

    log_output_level(CosimLogLevel.WARNING)


def _cosim(built: Fmu):  # libcosimpy is untyped
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 # only where it is published
    from libcosimpy.CosimManipulator import CosimManipulator  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    _quiet_cosim()
    execution = CosimExecution.from_step_size(round(STEP * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(built.path), instance_name="model"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    return execution, observer, manipulator, index


def _tbb() -> Path:
    """The library that ecos needs and does not bring along."""
    for entry in importlib.metadata.files("tbb") or []:
        if entry.name == "libtbb.so.12":
            return Path(str(entry.locate())).resolve()
    pytest.skip("the package tbb is not installed")


def _ecospy():  # ecospy is untyped
    ctypes.CDLL(str(_tbb()), ctypes.RTLD_GLOBAL)
    import ecospy  # noqa: PLC0415 # loads only after the library above

    return ecospy


@needs_clients
@pytest.mark.parametrize(
    ("name", "kind"), [("joint4", "native"), ("freedom6s", "native"), ("joint4", "native3"), ("freedom6s", "native3")]
)
def test_ecos(name: str, kind: Kind):
    ecospy, e = _ecospy(), equations(name)
    structure = ecospy.EcosSimulationStructure()
    structure.add_model("model", str(fmu(name, kind).path))
    u, got = torques(e, T), []
    with ecospy.EcosSimulation(STEP, structure=structure) as simulation:
        simulation.init()
        for row in u[:-1]:
            for x, value in zip(names(e, e.inputs), row, strict=True):
                simulation.set_real(f"model::{x}", value)
            simulation.step()
            got.append([simulation.get_real(f"model::{x}") for x in names(e, e.outputs[: len(e.joints)])])
    np.testing.assert_allclose(got, expected(name)[1:, : len(e.joints)], rtol=0, atol=ROUNDING)


def system(tmp_path: Path) -> Path:
    """A joint under a controller, 0.15 rad asked for."""
    brain = build_fmu(controller(), tmp_path / "controller.fmu", kind="native", platforms=this_platform())
    wires = (("controller", "torque", "joint", "joint4.torque"), ("joint", "joint4.reading", "controller", "reading"))
    return write_ssp(
        tmp_path / "system.ssp",
        {"joint": fmu("joint4", "native").path, "controller": brain.path},
        [Connection(from_component=a, from_variable=b, to_component=c, to_variable=d) for a, b, c, d in wires],
        parameters={"controller": {"target": 0.15}},
    )


def by_hand(steps: int, h: float) -> np.ndarray:
    """The two kernels, exchanging values after each step, as a Jacobi-type co-simulation does."""
    arm, brain = kernel("joint4"), CompiledKernel.of(controller())
    p, c = initial(equations("joint4")), initial(controller())
    c[0] = 0.15
    x, z, q, torque, rows = np.zeros(3), np.zeros(2), 0.0, brain.output(0, np.zeros(2), [0.0], c)[0], []
    for k in range(steps):
        t = np.array([k * h, (k + 1) * h])
        x, z = advanced(arm, x, t[0], h, [torque], p), advanced(brain, z, t[0], h, [q], c)
        torque, q = brain.output(t[1], z, [q], c)[0], arm.output(t[1], x, [torque], p)[0]
        rows.append(q)
    return np.array(rows)


@needs_clients
def test_a_system_of_two_gives_the_same_in_two_clients(tmp_path):
    ecospy, archive, h, steps = _ecospy(), system(tmp_path), 1e-3, 500
    with ecospy.EcosSimulation(h, ssp_path=str(archive)) as simulation:
        simulation.init(parameter_set="parameters")
        ecos = []
        for _ in range(steps):
            simulation.step()
            ecos.append(simulation.get_real("joint::joint4.reading"))
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 # only where it is published
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415

    _quiet_cosim()
    execution = CosimExecution.from_ssp_file(str(archive), step_size=round(h * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    index = execution.slave_index_from_instance_name("joint")
    reference = next(v.reference for v in execution.slave_variables(index) if v.name == b"joint4.reading")
    cosim = []
    for _ in range(steps):
        execution.step()
        cosim += observer.last_real_values(index, [reference])
    np.testing.assert_allclose(ecos, cosim, rtol=0, atol=1e-10)
    assert 0.1 < cosim[-1] < 0.2
    np.testing.assert_allclose(cosim, by_hand(steps, h), rtol=0, atol=1e-10)


@needs_clients
def test_the_ecos_command_line_without_python(tmp_path):
    binary = tmp_path / "ecos"
    shutil.copy(Path(_ecospy().__file__).parent / "binaries" / "ecos", binary)
    binary.chmod(0o755)
    environment = {**os.environ, "LD_LIBRARY_PATH": str(_tbb().parent)}
    arguments = ["simulate", "--path", str(system(tmp_path)), "--stopTime", "0.5", "--stepSize", "0.001"]
    call = [binary, *arguments, "--parameterSet", "parameters"]
    done = subprocess.run(call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    table = (tmp_path / "system.csv").read_text().splitlines()
    column = [cell.strip() for cell in table[0].split(",")].index("joint::joint4.reading[REAL]")
    rows = np.array([[float(cell) for cell in line.split(",")] for line in table[1:]])
    np.testing.assert_allclose(rows[1:, column], by_hand(rows.shape[0] - 1, 1e-3), rtol=0, atol=2e-6)
