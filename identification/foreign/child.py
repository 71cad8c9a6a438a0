"""Child process of a foreign FMU: `Request` in, outputs or an error sentence out.

The FMU's code is loaded in this process and nowhere else.
"""

from __future__ import annotations

import os
from multiprocessing.connection import Connection
from typing import Any

from fmpy.simulation import instantiate_fmu

from haptid.identification.foreign.archive import Unpacked
from haptid.identification.foreign.co_simulation import Request, initialise, step_by_itself
from haptid.identification.foreign.model_exchange import integrate
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import one_line
from haptid.support.processes.pool import end_with_the_parent

_ERROR, _FATAL = 3, 4
"""Status of FMI 2.0 and 3.0 of a call that failed, and of one after which an instance must not be used."""


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
    end_with_the_parent()  # a step that never returns would outlive a parent that was killed
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


def _instantiate(unpacked: Unpacked) -> Any:
    """Instantiate the FMU; where it refuses, say why in its own words."""
    try:
        return instantiate_fmu(str(unpacked.folder), unpacked.description, fmi_type=unpacked.interface)
    except Exception as error:
        words = _words_of_refusal(unpacked)
        msg = f"{error}: {words}" if words else str(error)
        raise RuntimeError(msg) from error


def _words_of_refusal(unpacked: Unpacked) -> str:
    """Instantiate once more with logging on, which slows simulations; the last message of an error, empty if none."""
    messages: list[str] = []

    def hear(*arguments: Any) -> None:  # of FMI 2.0 and 3.0: the last three are status, category, message
        status, _, message = arguments[-3:]
        if status >= _ERROR and message:
            messages.append(message.decode(errors="replace"))

    try:
        instantiate_fmu(
            str(unpacked.folder), unpacked.description, fmi_type=unpacked.interface, debug_logging=True, logger=hear
        ).freeInstance()
    except Exception:  # it is the messages that are wanted
        return one_line(messages[-1]) if messages else ""
    return ""


def _simulate(unpacked: Unpacked, request: Request) -> Array:
    fmu = _instantiate(unpacked)
    step = step_by_itself if unpacked.interface == "CoSimulation" else integrate
    try:
        initialise(fmu, unpacked.description, request)
        result = step(fmu, unpacked.description, request)
        fmu.terminate()
    except Exception as error:
        # An FMU may allow one instance a process, so that a refused simulation must not leave its own. After a fatal
        # error the standard allows no further call.
        if getattr(error, "status", 0) < _FATAL:
            fmu.freeInstance()
        raise
    fmu.freeInstance()
    return result
