"""Simulation of an instance for model exchange by CVode: instance and `Request` in, outputs at the rows out.

Inputs hold their value between rows; where one changes, an event lets the model and the solver know. State, time and
step events are handled as FMI 2.0.4, section 3.2.3, and FMI 3.0, section 3.2, prescribe. It runs in the child process
of a foreign FMU.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from fmpy.sundials import CVodeSolver

from haptid.identification.foreign.co_simulation import Request
from haptid.identification.foreign.variables import reader, writer
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array


class _HeldInput:
    """Input for fmpy's solver, which sets it before it looks for events: it is set at the rows only."""

    def apply(self, time: float) -> None:
        """Leave the inputs as they are."""


class _Events:
    """Event mode of an instance, which begins in the state after initialisation.

    ``next_time`` is the time of the next event that the model itself has planned [s]; infinite where there is none.
    """

    def __init__(self, fmu: Any, description: Any) -> None:
        self._fmu = fmu
        self._update = fmu.newDiscreteStates if description.fmiVersion == "2.0" else fmu.updateDiscreteStates
        self.next_time = math.inf
        self.finish()

    def begin(self) -> None:
        """Enter the event mode."""
        self._fmu.enterEventMode()

    def finish(self) -> None:
        """Update the discrete states until they no longer change, and go on in continuous time."""
        again = True
        while again:
            again, ends, _, _, planned, time = self._update()
            if ends:
                msg = "it asked to end the simulation at an event"
                raise RuntimeError(msg)
        self.next_time = float(time) if planned else math.inf
        self._fmu.enterContinuousTimeMode()


def integrate(fmu: Any, description: Any, request: Request) -> Array:
    """Integrate an initialised instance for model exchange from row to row.

    Parameters
    ----------
    fmu
        Instance, as fmpy made it.
    description
        Its model description.
    request
        Times, inputs and outputs.

    Returns
    -------
    ndarray, shape (n_t, n_outputs)
        Outputs at each row after its inputs are set.
    """
    events = _Events(fmu, description)
    write = writer(fmu, description, list(request.inputs))
    read = reader(fmu, description, request.outputs)
    solver = _solver(fmu, description, request)
    table, between, t = request.table, request.between, request.t
    present = table[0]
    result = np.empty((t.size, len(request.outputs)))
    for k in range(t.size):
        for part, inputs in enumerate((table[k], *between[k : k + 1])):
            if np.any(inputs != present):
                events.begin()
                write(inputs)
                events.finish()
                solver.reset(float(t[k]))
                present = inputs
            # The outputs of a row belong to its own inputs, not to those between it and the next.
            if part == 0:
                result[k] = read()
        if k + 1 < t.size:
            _advance(fmu, description, solver, events, float(t[k]), float(t[k + 1]))
    return result


def _solver(fmu: Any, description: Any, request: Request) -> Any:
    third = description.fmiVersion.startswith("3.")
    return CVodeSolver(
        nx=description.numberOfContinuousStates,
        nz=description.numberOfEventIndicators,
        get_x=fmu.getContinuousStates,
        set_x=fmu.setContinuousStates,
        get_dx=fmu.getContinuousStateDerivatives if third else fmu.getDerivatives,
        get_z=fmu.getEventIndicators,
        get_nominals=fmu.getNominalsOfContinuousStates,
        set_time=fmu.setTime,
        input=_HeldInput(),
        startTime=float(request.t[0]),
        maxStep=float(np.ptp(request.t)) * THRESHOLDS.largest_exchange_step_over_duration,
        relativeTolerance=THRESHOLDS.relative_tolerance_of_exchange,
        maxNumSteps=THRESHOLDS.most_exchange_steps_between_rows,
    )


def _advance(fmu: Any, description: Any, solver: Any, events: _Events, time: float, end: float) -> None:
    """Integrate from one row to the next, with all events between."""
    asks = description.modelExchange.needsCompletedIntegratorStep
    nearest = THRESHOLDS.least_exchange_step_over_time * max(abs(end), end - time)
    while end - time > nearest:
        until = min(end, max(events.next_time, time))
        event = events.next_time <= end and until - time <= nearest
        if not event:
            event, _, time = solver.step(time, until)
            fmu.setTime(time)
            if asks:
                step_event, ends = fmu.completedIntegratorStep()
                event = event or step_event
                if ends:
                    msg = f"it asked to end the simulation at t = {time:g} s"
                    raise RuntimeError(msg)
            event = event or events.next_time - time <= nearest
        if event:
            events.begin()
            events.finish()
            solver.reset(time)
