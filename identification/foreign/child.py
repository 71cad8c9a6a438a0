"""Child process of a foreign FMU: `Request` in, outputs or an error sentence out.

The FMU's code is loaded in this process and nowhere else.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from fmpy.simulation import apply_start_values, instantiate_fmu

from haptid.identification.foreign.archive import Unpacked
from haptid.identification.thresholds import THRESHOLDS
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
        Values that are set at each row by variable, shape (n_t,) each; a value holds until the next row.
    outputs
        Variables that are read at each row.
    """

    t: Array
    start: Mapping[str, float]
    inputs: Mapping[str, Array]
    outputs: Sequence[str]


def serve(connection: Connection, unpacked: Unpacked) -> None:
    """Answer requests until the connection is closed.

    Parameters
    ----------
    connection
        Connection to the parent: True is sent first, then for every `Request` the outputs, shape (n_t, n_outputs), or a
        sentence that says what failed.
    unpacked
        The FMU on disk.
    """
    _quiet()
    connection.send(True)
    while True:
        try:
            request: Request = connection.recv()
        except EOFError:
            return
        answer: Array | str
        try:
            answer = _simulate(unpacked, request)
        except Exception as error:  # whatever the FMU's functions report: the parent gets the sentence and goes on
            answer = str(error) or type(error).__name__
        connection.send(answer)


def _quiet() -> None:
    """Discard what the FMU prints, write no core dump, and bound the size of the files that the FMU writes."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)
    if os.name == "posix":
        import resource  # noqa: PLC0415 # POSIX alone has it

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(
            resource.RLIMIT_FSIZE, (THRESHOLDS.largest_written_file_bytes, THRESHOLDS.largest_written_file_bytes)
        )


def _simulate(unpacked: Unpacked, request: Request) -> Array:
    description = unpacked.description
    fmu: Any = instantiate_fmu(str(unpacked.folder), description, fmi_type="CoSimulation")
    of = {v.name: v.valueReference for v in description.modelVariables}
    second = description.fmiVersion == "2.0"
    write, read = (fmu.setReal, fmu.getReal) if second else (fmu.setFloat64, fmu.getFloat64)
    inputs, outputs = [of[name] for name in request.inputs], [of[name] for name in request.outputs]
    table = np.column_stack([np.zeros((request.t.size, 0)), *request.inputs.values()])
    first = float(request.t[0])
    # FMI 2.0 takes the start time before the start values, FMI 3.0 with the initialization mode.
    if second:
        fmu.setupExperiment(startTime=first)
    apply_start_values(fmu, description, dict(request.start))
    fmu.enterInitializationMode() if second else fmu.enterInitializationMode(startTime=first)
    if inputs:
        write(inputs, table[0].tolist())
    fmu.exitInitializationMode()
    result = np.empty((request.t.size, len(outputs)))
    for k, t in enumerate(request.t):
        if inputs:
            write(inputs, table[k].tolist())
        result[k] = read(outputs)
        if k + 1 < request.t.size:
            fmu.doStep(float(t), float(request.t[k + 1] - t))
    fmu.terminate()
    fmu.freeInstance()
    return result
