"""The closed loop as two FMUs: FMU of the device and `Controller` in, controller's FMU and system (SSP) out.

1. Build the FMU of the stated controller (`build_controller`).
2. Run both FMUs by fmpy along a verified run (`simulate_pair`) and compare with the verification in process.
3. Write both as one system (`Pair.write_system`).
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from haptid.fmu_build.building.packaging import Fmu, Kind, build_fmu
from haptid.fmu_build.description.variables import structured_name
from haptid.fmu_build.exchange.ssp import Connection, write_ssp
from haptid.fmu_build.native.platforms import Platform
from haptid.identification.simulators.closed_loop import Controller, reference_of
from haptid.identification.simulators.controller_equations import controller_equations
from haptid.identification.verification.result import Verification
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """FMUs of the closed loop.

    Parameters
    ----------
    device
        FMU of the whole device.
    controller
        FMU of its controller.
    """

    device: Fmu
    controller: Fmu

    def write_system(self, out: Path, *, stop_time: float) -> Path:
        """Write both FMUs as one system, with torques and readings connected and the parameters of both bound.

        Parameters
        ----------
        out
            Archive (SSP) to write.
        stop_time
            End of the default experiment [s].

        Returns
        -------
        Path
            The archive.
        """
        device, law = self.device.equations, self.controller.equations
        wires = []
        for k in range(len(device.joints)):
            torque, reading = _name(law, law.outputs[k]), _name(law, law.inputs[len(device.joints) + k])
            wires.append(("controller", torque, "device", _name(device, device.inputs[k])))
            wires.append(("device", _name(device, device.outputs[k]), "controller", reading))
        connections = [
            Connection(from_component=a, from_variable=b, to_component=c, to_variable=d) for a, b, c, d in wires
        ]
        fmus = {"device": self.device.path, "controller": self.controller.path}
        parameters = {component: _parameters(path) for component, path in fmus.items()}
        return write_ssp(out, fmus, connections, parameters=parameters, stop_time=stop_time, name="closed_loop")


def _parameters(fmu: Path) -> dict[str, float]:
    """Return the start values of the parameters, so that whoever changes the system finds them as a file in it."""
    variables = fmpy.read_model_description(str(fmu)).modelVariables
    return {v.name: float(v.start) for v in variables if v.causality == "parameter"}


def _name(equations: Equations, part: Any) -> str:
    return structured_name(equations, part.id, part.structured)


def build_controller(
    controller: Controller,
    run: Run,
    out: Path,
    *,
    kind: Kind = "native",
    platforms: tuple[Platform, ...] | None = None,
) -> Fmu:
    """Build the FMU of a controller for the joints and the sample time of a run.

    Parameters
    ----------
    controller
        Gains and time constant of the filter.
    run
        Run whose median time between rows is the sample time, and whose first readings the filters start at.
    out
        File to write.
    kind, platforms
        Packaging, and the platforms of native code.

    Returns
    -------
    Fmu

    Raises
    ------
    InputError
        Where the reference run gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    equations = controller_equations(controller, float(np.median(np.diff(run.t))), run.free_joints)
    start = {state.id: float(y) for state, y in zip(equations.states, run.y[0], strict=True)}
    return build_fmu(equations, out, kind=kind, values=start, platforms=platforms, largest_torque=run.largest_torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class ClosedLoopFiles:
    """Files of the closed loop.

    Parameters
    ----------
    controller, system
        FMU of the controller, and the system (SSP).
    largest_difference_rad
        Largest difference of the FMUs' positions from those of the verification in process [rad].
    """

    controller: Path
    system: Path
    largest_difference_rad: float

    def as_json(self) -> dict[str, Any]:
        """Convert to the entry ``as_fmus`` of identification.json.

        Returns
        -------
        dict
            Names of both files without folder, ``controller`` and ``system``, and ``largest_difference_rad``.
        """
        return {
            "controller": self.controller.name,
            "system": self.system.name,
            "largest_difference_rad": self.largest_difference_rad,
        }


def export_closed_loop(
    device: Fmu, table: Mapping[str, Any] | None, runs: Sequence[Run], checks: Verification, out: Path
) -> ClosedLoopFiles | None:
    """Write ``controller.fmu`` and ``closed_loop.ssp`` and run both FMUs along the first verified run.

    Parameters
    ----------
    device
        FMU of the whole device with the identified values.
    table
        The ``[controller]`` table of the campaign.
    runs
        Runs of the campaign.
    checks
        Verification in process that the FMUs are compared with.
    out
        Folder to write to.

    Returns
    -------
    ClosedLoopFiles or None
        None where the campaign states no controller or no run was verified in closed loop.

    Raises
    ------
    InputError
        Where the reference run of the controller gives no finite numbers.
    NumericalError
        Where the compiler is missing or fails.
    """
    done = [check for check in checks.runs if check.mode == "closed_loop"]
    if not table or not done:
        return None
    joints = device.equations.joints
    run = next(r for r in runs if r.file == done[0].file and r.free_joints == joints)
    reference = reference_of(run)
    if reference is None:
        return None
    law = Controller.from_table(table, len(joints))
    pair = Pair(device=device, controller=build_controller(law, run, out / "controller.fmu"))
    y, _ = simulate_pair(pair, run, reference)
    return ClosedLoopFiles(
        controller=pair.controller.path,
        system=pair.write_system(out / "closed_loop.ssp", stop_time=float(run.t[-1])),
        largest_difference_rad=float(np.max(np.abs(y - done[0].simulated))),
    )


class _Part:
    """Running instance of one FMU."""

    def __init__(self, fmu: Fmu, start: dict[str, float]) -> None:
        description = fmpy.read_model_description(str(fmu.path))
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.folder = fmpy.extract(str(fmu.path))
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=fmu.equations.name,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.set(list(start), list(start.values()))
        self.slave.exitInitializationMode()

    def set(self, names: list[str], values: list[float]) -> None:
        self.slave.setReal([self.references[name] for name in names], values)

    def get(self, names: list[str]) -> list[float]:
        return list(self.slave.getReal([self.references[name] for name in names]))

    def close(self) -> None:
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def simulate_pair(pair: Pair, run: Run, reference: Array) -> tuple[Array, Array]:
    """Run device and controller as FMUs along a run.

    Parameters
    ----------
    pair
        Both FMUs.
    run
        Run that gives times and first positions.
    reference
        Reference positions [rad], shape (n_t, n_q).

    Returns
    -------
    y : ndarray, shape (n_t, n_q)
        Positions [rad].
    torque : ndarray, shape (n_t, n_q)
        Torques of the controller [N m].

    Notes
    -----
    The readings reach the controller without delay, and its torque holds until the next row.
    """
    device, law, n = pair.device.equations, pair.controller.equations, len(run.free_joints)
    plant = _Part(pair.device, dict(zip([_name(device, s) for s in device.states[:n]], run.y[0].tolist(), strict=True)))
    brain = _Part(pair.controller, {})
    read, drive = [_name(device, o) for o in device.outputs[:n]], [_name(device, i) for i in device.inputs[:n]]
    taken, given = [_name(law, i) for i in law.inputs], [_name(law, o) for o in law.outputs]
    y, torque = np.empty((run.t.size, n)), np.empty((run.t.size, n))
    try:
        for k, t in enumerate(run.t):
            # Device, controller, device: the torque of a row depends on the reading of the same row.
            y[k] = plant.get(read)
            brain.set(taken, [*reference[k].tolist(), *y[k].tolist()])
            torque[k] = brain.get(given)
            plant.set(drive, torque[k].tolist())
            if k + 1 < run.t.size:
                step = float(run.t[k + 1] - t)
                brain.slave.doStep(float(t), step)
                plant.slave.doStep(float(t), step)
    finally:
        plant.close()
        brain.close()
    return y, torque
