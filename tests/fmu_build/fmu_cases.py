"""FMUs that the tests share, built once per process, and a client that steps them by fmpy alone."""

from __future__ import annotations

import ctypes
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.native.platforms import this_platform
from haptid.model.device.reader import load_device
from haptid.model.equations.equations import Equations
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.compiled import CompiledKernel

DEVICE = load_device("freedom6s")
KINDS: tuple[Kind, ...] = ("python", "native")
NAMES = ("joint4", "joints01", "freedom6s")
STEP = 0.005
FOLDER = Path(tempfile.mkdtemp(prefix="haptid_tests_"))


@cache
def equations(name: str) -> Equations:
    if name == "freedom6s":
        return full_equations(DEVICE)
    return configuration_equations(DEVICE, [int(j) for j in name.removeprefix("joints").removeprefix("joint")])


@cache
def kernel(name: str) -> CompiledKernel:
    return CompiledKernel.of(equations(name))


@cache
def fmu(name: str, kind: Kind, *, identification: bool = False) -> Fmu:
    path = FOLDER / f"{name}_{kind}{'_identification' * identification}.fmu"
    return build_fmu(equations(name), path, kind=kind, identification=identification, platforms=this_platform())


def torques(e: Equations, t: np.ndarray, amplitude: float = 5e-3) -> np.ndarray:
    """Cosines of different frequencies at the torques, nothing at the handle, shape (n_t, n_u)."""
    u = np.zeros((t.size, len(e.inputs)))
    for i, x in enumerate(e.inputs):
        if x.id.startswith("tau"):
            u[:, i] = amplitude * np.cos((1.0 + 0.3 * i) * t)
    return u


def initial(e: Equations) -> np.ndarray:
    return np.array([q.initial for q in e.parameters])


def names(e: Equations, quantities: Any) -> list[str]:
    return [structured_name(e, x.id, x.structured) for x in quantities]


def advanced(k: CompiledKernel, x: np.ndarray, t: float, h: float, u: list[float], p: np.ndarray) -> np.ndarray:
    """The state one communication step later, by the kernel alone."""
    advance = ctypes.CDLL(str(k.path)).hk_advance
    real, pointer = ctypes.c_double, ctypes.c_void_p
    advance.argtypes = [pointer, real, real, pointer, pointer, pointer, real]
    end, inputs, slopes = np.array(x, dtype=float), np.array(u, dtype=float), np.zeros(len(u))
    assert advance(end.ctypes.data, t, h, inputs.ctypes.data, slopes.ctypes.data, p.ctypes.data, k.kernel.step)
    return end


class Client:
    """One instance, by fmpy's own calls; `messages` keeps what the FMU logs."""

    def __init__(
        self, built: Fmu | Path, cls: type = FMU2Slave, name: str = "instance", guid: str | None = None
    ) -> None:
        path = built if isinstance(built, Path) else built.path
        self.description = fmpy.read_model_description(str(path))
        kind = self.description.modelExchange if cls is FMU2Model else self.description.coSimulation
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.fmi = cls(
            guid=guid or self.description.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=tempfile.mkdtemp(dir=FOLDER)),
            modelIdentifier=kind.modelIdentifier,
            instanceName=name,
        )
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._keep)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.fmi2.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.fmi2.free)
        self.fmi.instantiate(loggingOn=True, callbacks=callbacks)

    def _keep(self, _: object, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
        self.messages.append(message.decode())

    def set(self, **values: float) -> None:
        self.fmi.setReal([self.vr[name.replace("__", ".")] for name in values], list(values.values()))

    def assign(self, names: list[str], values: Any) -> None:
        self.fmi.setReal([self.vr[name] for name in names], [float(value) for value in values])

    def get(self, *wanted: str) -> list[float]:
        return list(self.fmi.getReal([self.vr[name] for name in wanted]))

    def start(self) -> Client:
        self.fmi.setupExperiment(startTime=0.0)
        self.fmi.enterInitializationMode()
        return self

    def go(self) -> Client:
        self.fmi.exitInitializationMode()
        return self

    def run(self, e: Equations, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Outputs (n_t, n_y) at the rows."""
        inputs, outputs, rows = names(e, e.inputs), names(e, e.outputs), []
        for k in range(t.size):
            self.assign(inputs, u[k])
            rows.append(self.get(*outputs))
            if k + 1 < t.size:
                self.fmi.doStep(t[k], t[k + 1] - t[k])
        return np.array(rows)
