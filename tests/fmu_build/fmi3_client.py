"""An FMI 3.0 instance by fmpy's own calls."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Model, FMU3Slave

from haptid.fmu_build.building.packaging import Fmu
from haptid.model.equations.equations import Equations
from tests.fmu_build.fmu_cases import FOLDER, fmu, names

FMPY = Path(fmpy.__file__).parent


def fmu3(name: str = "joint4") -> Fmu:
    return fmu(name, "native3")


class Client3:
    """One instance; `messages` keeps what the FMU logs."""

    def __init__(
        self,
        built: Fmu | Path,
        cls: type = FMU3Slave,
        name: str = "instance",
        token: str | None = None,
        logging: bool = True,
        **options: Any,
    ) -> None:
        path = built if isinstance(built, Path) else built.path
        self.description = fmpy.read_model_description(str(path))
        kind = self.description.modelExchange if cls is FMU3Model else self.description.coSimulation
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.messages: list[str] = []
        self.fmi = cls(
            guid=token or self.description.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=tempfile.mkdtemp(dir=FOLDER)),
            modelIdentifier=kind.modelIdentifier,
            instanceName=name,
        )
        self.fmi.instantiate(loggingOn=logging, logMessage=self._keep, **options)

    def _keep(self, _environment: object, _status: int, _category: bytes, message: bytes) -> None:
        self.messages.append(message.decode())

    def assign(self, names: list[str], values: Any) -> None:
        self.fmi.setFloat64([self.vr[name] for name in names], [float(value) for value in values])

    def get(self, *wanted: str) -> list[float]:
        return list(self.fmi.getFloat64([self.vr[name] for name in wanted]))

    def call(self, function: str, *arguments: Any) -> None:
        """Any function, also one that fmpy offers for the other interface only."""
        getattr(self.fmi, function)(self.fmi.component, *arguments)

    def start(self) -> Client3:
        self.fmi.enterInitializationMode(startTime=0.0)
        return self

    def go(self) -> Client3:
        self.fmi.exitInitializationMode()
        return self

    def run(self, e: Equations, t: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Outputs (n_t, n_y) at the rows."""
        inputs, outputs, rows = names(e, e.inputs), names(e, e.outputs), []
        for k in range(t.size):
            self.assign(inputs, u[k])
            rows.append(self.get(*outputs))
            if k + 1 < t.size:
                assert self.fmi.doStep(t[k], t[k + 1] - t[k]) == (False, False, False, t[k] + (t[k + 1] - t[k]))
        return np.array(rows)

    def states(self, values: list[float] | None = None) -> list[float]:
        """Set the continuous states where given, and read them."""
        n = self.fmi.getNumberOfContinuousStates()
        buffer = (ctypes.c_double * n)(*(values or [0.0] * n))
        if values is not None:
            self.fmi.setContinuousStates(buffer, n)
        self.fmi.getContinuousStates(buffer, n)
        return list(buffer)

    def rates(self) -> list[float]:
        """The continuous states' derivatives."""
        n = self.fmi.getNumberOfContinuousStates()
        buffer = (ctypes.c_double * n)()
        self.fmi.getContinuousStateDerivatives(buffer, n)
        return list(buffer)


def exchange(name: str = "joint4") -> Client3:
    """An instance for model exchange in continuous-time mode."""
    client = Client3(fmu3(name), FMU3Model).start().go()
    assert client.fmi.updateDiscreteStates() == (False, False, False, False, False, 0.0)
    client.fmi.enterContinuousTimeMode()
    return client
