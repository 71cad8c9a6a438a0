"""What one identification is asked for (`Job`), and what comes out of it (`Identification`)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from haptid.fmu_build.building.cached import identification_fmu
from haptid.fmu_build.building.packaging import Kind
from haptid.identification.problem.options import FitOptions
from haptid.identification.sequence.carried_fit import FILE
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.sequence.sequence import Build
from haptid.identification.sequence.step import Step
from haptid.identification.simulators.fmu import FmuSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.identification.verification.result import Verification
from haptid.measurement.values.campaign import Campaign
from haptid.model.device.device import Device
from haptid.model.equations.equations import Equations
from haptid.support.files.files import write_json


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Inputs of one identification.

    Parameters
    ----------
    campaign
        Campaign that is ready for fits.
    device
        Device of the campaign; None for a single joint.
    configurations
        Configurations to fit, in order.
    options
        Choices of the fits.
    kind
        Packaging of the FMU that the fits run; None runs the kernel in process.
    out
        Folder of the results.
    scheduler
        Address of a Dask scheduler; None runs in this process or in processes of this machine.
    made_by
        Command or call, for the reader of the results.
    """

    campaign: Campaign
    device: Device | None
    configurations: tuple[Configuration, ...]
    options: FitOptions
    kind: Kind | None
    out: Path
    scheduler: str | None
    made_by: str

    @property
    def build(self) -> Build:
        """Function from equations to the simulator that runs the fits; picklable."""
        return partial(_simulator_of, self.kind)

    @property
    def file(self) -> Path:
        """File of the results."""
        return self.out / FILE


def _simulator_of(kind: Kind | None, equations: Equations) -> Simulator:
    if kind is None:
        return KernelSimulator.of(equations)
    return FmuSimulator.of(identification_fmu(equations, kind=kind), equations)


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """Result of one identification.

    Parameters
    ----------
    steps
        Fitted configurations, in the order of their fits.
    verification
        What the whole device misses on runs with all joints free; without runs where it was not identified.
    data
        Content of ``identification.json``.
    build
        Function from equations to the simulator that ran the fits.
    workers
        Most processes or threads of what follows [1].
    """

    steps: tuple[Step, ...]
    verification: Verification
    data: dict[str, Any]
    build: Build
    workers: int = 1

    def finish(self, folder: Path) -> None:
        """Write ``identification.json`` as complete: an interrupted identification is continued only before.

        Parameters
        ----------
        folder
            Folder of the results.

        Raises
        ------
        InputError, WritingError
            As `write_json`.
        """
        self.data["complete"] = True
        write_json(folder / FILE, self.data)
