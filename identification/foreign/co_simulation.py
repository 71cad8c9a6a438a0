"""Simulation of an instance by its own solver: instance and `Request` in, outputs at the rows out.

It runs in the child process of a foreign FMU.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from fmpy.simulation import apply_start_values

from haptid.identification.foreign.variables import reader, writer
from haptid.measurement.values.run import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """One simulation.

    Parameters
    ----------
    t
        Times of the rows [s], shape (n_t,).
    start
        Start values by variable.
    inputs
        Values that are set at each row by variable, shape (n_t,) each.
    outputs
        Variables that are read at each row.
    linear
        Whether the inputs are linear between rows: their mean of two rows is then set between them. Else a value holds
        until the next row.
    """

    t: Array
    start: Mapping[str, float]
    inputs: Mapping[str, Array]
    outputs: Sequence[str]
    linear: bool = False

    @property
    def table(self) -> Array:
        """Inputs by row, shape (n_t, n_inputs)."""
        return np.column_stack([np.zeros((self.t.size, 0)), *self.inputs.values()])

    @property
    def between(self) -> Array:
        """Inputs after each row but the last, shape (n_t - 1, n_inputs)."""
        table = self.table
        return 0.5 * (table[:-1] + table[1:]) if self.linear else table[:-1]


def initialise(fmu: Any, description: Any, request: Request) -> None:
    """Set the start values before initialisation, then initialise with the first row's inputs.

    Parameters
    ----------
    fmu
        New instance, as fmpy made it.
    description
        Its model description.
    request
        Start values, times and inputs.

    Raises
    ------
    Exception
        Whatever fmpy raises where a function of the FMU reports an error.
    """
    first = float(request.t[0])
    # FMI 2.0 takes the start time before the start values, FMI 3.0 with the initialization mode.
    second = description.fmiVersion == "2.0"
    if second:
        fmu.setupExperiment(startTime=first)
    apply_start_values(fmu, description, dict(request.start))
    fmu.enterInitializationMode() if second else fmu.enterInitializationMode(startTime=first)
    if request.inputs:
        writer(fmu, description, list(request.inputs))(request.table[0])
    fmu.exitInitializationMode()


def step_by_itself(fmu: Any, description: Any, request: Request) -> Array:
    """Step an initialised instance for co-simulation from row to row.

    Parameters
    ----------
    fmu, description, request
        As in `initialise`.

    Returns
    -------
    ndarray, shape (n_t, n_outputs)
        Outputs at each row after its inputs are set.

    Raises
    ------
    RuntimeError
        Where an FMU of FMI 3.0 asks to end the simulation.
    """
    write = writer(fmu, description, list(request.inputs))
    read = reader(fmu, description, request.outputs)
    table, between, t = request.table, request.between, request.t
    result = np.empty((t.size, len(request.outputs)))
    for k in range(t.size):
        write(table[k])
        result[k] = read()
        if k + 1 < t.size:
            if request.linear:
                write(between[k])
            answer = fmu.doStep(float(t[k]), float(t[k + 1] - t[k]))
            # FMI 3.0 answers with flags, of which the second asks for the end of the simulation.
            if isinstance(answer, tuple) and answer[1]:
                msg = f"it asked to end the simulation at t = {t[k + 1]:g} s"
                raise RuntimeError(msg)
    return result
