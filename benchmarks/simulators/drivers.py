"""Clients of FMUs, each as a function: archive and its reference inputs in, outputs at the rows out.

Rows are read when a step is done, before the next inputs are set, as in the FMI cross-check. An integrator with a
tolerance solves the equations, not the inner steps of the FMU: it is compared with the FMU in steps so short that their
error is below the aim.
"""

from __future__ import annotations

import ctypes
import importlib
import importlib.metadata
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu, simulate_fmu
from numpy.typing import NDArray

Array = NDArray[np.float64]


class NotHere(Exception):  # noqa: N818 # no error: a client that this machine does not have
    """Why a client does not run here."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """The reference run of an FMU.

    Parameters
    ----------
    t
        Rows [s], shape (n_t,).
    inputs, outputs
        FMU variable names.
    u, y
        Values at the rows, shape (n_t, n_u) and (n_t, n_y).
    """

    t: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    u: Array
    y: Array


def drive_of(archive: Path) -> Drive:
    """Read the reference run from an FMU."""
    with ZipFile(archive) as files:
        (stem,) = {Path(n).name.removesuffix("_ref.csv") for n in files.namelist() if n.endswith("_ref.csv")}
        texts = [files.read(f"documentation/{stem}_{part}.csv").decode() for part in ("in", "ref")]
    heads = [tuple(cell.strip('"') for cell in text.splitlines()[0].split(",")) for text in texts]
    given, wanted = (np.array([[float(x) for x in line.split(",")] for line in t.splitlines()[1:]]) for t in texts)
    return Drive(t=given[:, 0], inputs=heads[0][1:], outputs=heads[1][1:], u=given[:, 1:], y=wanted[:, 1:])


def _simulate(archive: Path | str, drive: Drive, interface: str, **options: object) -> Array:
    signals = np.zeros(drive.t.size, dtype=[("time", "f8"), *((name, "f8") for name in drive.inputs)])
    signals["time"] = drive.t
    for name, column in zip(drive.inputs, drive.u.T, strict=True):
        signals[name] = column
    step = float(drive.t[-1]) / (drive.y.shape[0] - 1)
    found = simulate_fmu(
        str(archive), input=signals, output=list(drive.outputs), stop_time=float(drive.t[-1]), output_interval=step,
        step_size=step, fmi_type=interface, use_event_mode=False, **options,
    )  # fmt: skip
    # where an input jumps, FMPy records the row before and after; the first is read before the next inputs are set
    first = np.unique(np.round(found["time"] / step).astype(int), return_index=True)[1]
    return np.column_stack([found[name][first] for name in drive.outputs])


def by_fmpy(archive: Path, drive: Drive) -> Array:
    """Simulate by FMPy's co-simulation."""
    return _simulate(archive, drive, "CoSimulation")


def by_compiled_source(archive: Path, drive: Drive) -> Array:
    """Compile the source in the archive by CMake and the machine's own compiler, as ``fmpy compile``; simulate that."""
    if not (shutil.which("cmake") and shutil.which("gcc")):
        msg = "CMake or GCC is not installed"
        raise NotHere(msg)
    own = Path(tempfile.mkdtemp()) / archive.name
    with ZipFile(archive) as files, ZipFile(own, "w") as kept:  # what runs is what was compiled
        for name in files.namelist():
            if not name.startswith("binaries/"):
                kept.writestr(name, files.read(name))
    subprocess.run([sys.executable, "-m", "fmpy", "compile", str(own)], check=True, capture_output=True)
    return _simulate(own, drive, "CoSimulation")


PARTS = 1280
"""Parts of a communication step of 5 ms in which an FMU is stepped for comparison with an integrator: 3.9 µs."""


def by_reference_run(_archive: Path, drive: Drive) -> Array:
    """Return the reference run itself."""
    return drive.y


def in_short_steps(archive: Path, drive: Drive) -> Array:
    """Simulate by FMPy's co-simulation in steps of a 1280th of the rows', the inputs held over each row's."""
    about = fmpy.read_model_description(str(archive))
    references = {v.name: int(v.valueReference) for v in about.modelVariables}
    inputs, outputs = ([references[name] for name in names] for names in (drive.inputs, drive.outputs))
    fmu = instantiate_fmu(fmpy.extract(str(archive)), about, fmi_type="CoSimulation")
    is_fmi2 = about.fmiVersion == "2.0"
    if is_fmi2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    set_values, get_values = (fmu.setReal, fmu.getReal) if is_fmi2 else (fmu.setFloat64, fmu.getFloat64)
    rows = [drive.y[0]]
    for k in range(drive.t.size - 1):
        set_values(inputs, drive.u[k].tolist())
        length = float(drive.t[k + 1] - drive.t[k]) / PARTS
        for part in range(PARTS):
            fmu.doStep(float(drive.t[k]) + part * length, length)
        rows.append(np.array(get_values(outputs)))
    return np.array(rows)


def _with_jumps(drive: Drive) -> Drive:
    """State the torque twice at each row, before and after: FMPy's model exchange runs inputs linearly between rows."""
    t = np.repeat(drive.t, 2)[1:]
    u = np.repeat(drive.u, 2, axis=0)[:-1]
    return Drive(t=t, inputs=drive.inputs, outputs=drive.outputs, u=u, y=drive.y)


def by_cvode(archive: Path, drive: Drive) -> Array:
    """Integrate by model exchange with FMPy's CVode; the torque is held as in the reference run."""
    if fmpy.read_model_description(str(archive)).modelExchange is None:
        msg = "the packaging has no model exchange"
        raise NotHere(msg)
    return _simulate(archive, _with_jumps(drive), "ModelExchange", solver="CVode", relative_tolerance=1e-13)


def by_libcosim(archive: Path, drive: Drive) -> Array:
    """Simulate by libcosim."""
    try:
        from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 # published for some platforms only
        from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415
        from libcosimpy.CosimManipulator import CosimManipulator  # noqa: PLC0415
        from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
        from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415
    except ImportError as error:
        raise NotHere(str(error)) from None
    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_step_size(round((drive.t[1] - drive.t[0]) * 1e9))
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(archive), instance_name="model"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    references = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    rows = [drive.y[0]]
    for values in drive.u[:-1]:
        manipulator.slave_real_values(index, [references[name] for name in drive.inputs], list(values))
        execution.step()
        rows.append(observer.last_real_values(index, [references[name] for name in drive.outputs]))
    return np.array(rows)


def _ecospy() -> Any:
    """Import ecospy after the library that it needs and does not bring along."""
    for entry in importlib.metadata.files("tbb") or []:
        if entry.name == "libtbb.so.12":
            ctypes.CDLL(str(Path(str(entry.locate())).resolve()), ctypes.RTLD_GLOBAL)
    import ecospy  # noqa: PLC0415 # loads only after the library above

    return ecospy


def by_ecos(archive: Path, drive: Drive) -> Array:
    """Simulate by ecos."""
    try:
        ecospy = _ecospy()
    except (ImportError, importlib.metadata.PackageNotFoundError) as error:
        raise NotHere(str(error)) from None
    structure = ecospy.EcosSimulationStructure()
    structure.add_model("model", str(archive))
    rows = [drive.y[0]]
    with ecospy.EcosSimulation(float(drive.t[1] - drive.t[0]), structure=structure) as simulation:
        simulation.init()
        for values in drive.u[:-1]:
            for name, value in zip(drive.inputs, values, strict=True):
                simulation.set_real(f"model::{name}", float(value))
            simulation.step()
            rows.append([simulation.get_real(f"model::{name}") for name in drive.outputs])
    return np.array(rows)


def by_fmuloader(archive: Path, drive: Drive) -> Array:
    """Step by fmuloader's bindings of FMI 3.0."""
    try:
        # No package that haptid declares: it takes part where somebody has installed it.
        slave_of = importlib.import_module("fmuloader.fmi3").Fmi3Slave
    except ImportError as error:
        raise NotHere(str(error)) from None
    about = fmpy.read_model_description(str(archive))
    references = {v.name: int(v.valueReference) for v in about.modelVariables}
    inputs, outputs = ([references[name] for name in names] for names in (drive.inputs, drive.outputs))
    rows = [drive.y[0]]
    slave = slave_of(archive, model_identifier=about.coSimulation.modelIdentifier)
    slave.instantiate_co_simulation("model", instantiation_token=about.guid)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    for k in range(drive.t.size - 1):
        slave.set_float64(inputs, drive.u[k].tolist())
        slave.do_step(float(drive.t[k]), float(drive.t[k + 1] - drive.t[k]))
        rows.append(np.array(slave.get_float64(outputs)))
    return np.array(rows)


Driver = Callable[[Path, Drive], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class Client:
    """A client.

    Parameters
    ----------
    name
        As a reader knows it.
    package
        Distribution whose version is stored.
    run
        The function above.
    kinds
        Packagings that it takes.
    how
        The command or the calls of the client.
    truth
        What its outputs are compared with.
    aim
        Largest difference that counts as the same run.
    """

    name: str
    package: str
    run: Driver
    kinds: tuple[str, ...]
    how: str
    truth: Driver = by_reference_run
    aim: float = 1e-9


CLIENTS = {
    "fmpy": Client(
        name="FMPy", package="fmpy", run=by_fmpy, kinds=("python", "native", "native3"),
        how="fmpy simulate NAME.fmu --interface-type CoSimulation --output-interval 0.005 --input-file NAME_in.csv",
    ),
    "fmpy_compile": Client(
        name="FMPy, the source by CMake and GCC", package="fmpy", run=by_compiled_source, kinds=("native", "native3"),
        how="fmpy compile NAME.fmu && fmpy simulate NAME.fmu …",
    ),
    "fmpy_cvode": Client(
        name="FMPy, model exchange by CVode", package="fmpy", run=by_cvode, kinds=("native", "native3"),
        how="fmpy simulate NAME.fmu --interface-type ModelExchange --solver CVode --relative-tolerance 1e-13 …",
        truth=in_short_steps,
    ),
    "libcosim": Client(
        name="libcosim", package="libcosimpy", run=by_libcosim, kinds=("python", "native"),
        how="libcosimpy: CosimExecution.step, CosimObserver.last_real_values",
    ),
    "ecos": Client(
        name="ecos", package="ecospy", run=by_ecos, kinds=("native", "native3"),
        how="ecospy: EcosSimulation.step, get_real",
    ),
    "fmuloader": Client(
        # Its FMI 2.0 cuts the addresses of its calloc to 32 bits, and asks every FMU for both interfaces.
        name="fmuloader", package="fmuloader", run=by_fmuloader, kinds=("native3",), how="fmuloader: Fmi3Slave.do_step",
    ),
}  # fmt: skip
"""Clients by the word that names them on the command line."""


def main(word: str, archive: str) -> None:
    """Run one client on one FMU and print the outputs' largest difference by column, a line each.

    Where its truth is not the reference run, a last line has the largest difference to that.
    """
    client, drive = CLIENTS[word], drive_of(Path(archive))
    try:
        rows = client.run(Path(archive), drive)
    except NotHere as reason:
        sys.stdout.write(f"NOT HERE {reason}\n")
        return
    for name, theirs, ours in zip(drive.outputs, rows.T, client.truth(Path(archive), drive).T, strict=True):
        sys.stdout.write(f"COLUMN {name} {float(np.abs(theirs - ours).max())!r}\n")
    if client.truth is not by_reference_run:
        sys.stdout.write(f"REFERENCE {float(np.abs(rows - drive.y).max())!r}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
