"""A loaded FMI 2.0 co-simulation slave: path of an FMU in, `FmuSlave` out, which turns inputs into outputs.

fmpy unpacks, loads and initialises the slave; a compiled loop (fmu_driver.c) steps it from row to row.
"""

from __future__ import annotations

import ctypes
import hashlib
import shutil
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    free,
)
from fmpy.model_description import ModelDescription

from haptid.measurement.values.run import Array
from haptid.model.kernel.compiler import compile_shared
from haptid.model.kernel.pieces import pieces
from haptid.model.thresholds import THRESHOLDS
from haptid.support.errors import NumericalError
from haptid.support.files.cache import cache_folder, is_sealed, seal, writing_to_cache

FUNCTIONS = ("fmi2SetReal", "fmi2GetReal", "fmi2DoStep")
"""Functions of the FMU that the compiled loop calls, in the order of its arguments."""
KEPT_MESSAGES = 20
"""Number of the slave's messages that are kept beside the latest one."""


@lru_cache(maxsize=1)
def _driver_path() -> Path:
    text = resources.files("haptid.identification.simulators").joinpath("fmu_driver.c").read_text(encoding="utf-8")
    return compile_shared({"fmu_driver.c": text}, main=("fmu_driver.c",))


@lru_cache(maxsize=2)
def _driver(*, hold_lock: bool) -> Any:
    """Return the compiled loop; slaves in Python run faster where the loop holds the interpreter's lock throughout."""
    library = (ctypes.PyDLL if hold_lock else ctypes.CDLL)(str(_driver_path()))
    run = library.hd_run
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    run.restype = ctypes.c_long
    run.argtypes = [
        pointer,
        pointer,
        pointer,
        pointer,
        ctypes.c_long,
        pointer,
        size,
        pointer,
        pointer,
        size,
        pointer,
        pointer,
    ]
    return run


def unpack_fmu(path: Path) -> Path:
    """Unpack an FMU into the cache, once for every content.

    Parameters
    ----------
    path
        Archive of the FMU.

    Returns
    -------
    Path
        Folder with the archive's content, named by the digest of the archive.
    """
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:24]
    folder = cache_folder("unpacked") / digest
    if not is_sealed(folder):
        # Unpacked aside and then renamed: no other process ever sees a folder that is half full.
        fresh = Path(tempfile.mkdtemp(dir=folder.parent))
        try:
            with writing_to_cache():
                fmpy.extract(str(path), unzipdir=str(fresh))
        except BaseException:
            shutil.rmtree(fresh, ignore_errors=True)
            raise
        if folder.exists() and not is_sealed(folder):  # damaged, or another process is about to seal it
            folder.rename(fresh.with_name(f"{fresh.name}.old"))
        try:
            fresh.rename(folder)
        except OSError:  # another process was first
            shutil.rmtree(fresh)
        seal(folder)
        shutil.rmtree(fresh.with_name(f"{fresh.name}.old"), ignore_errors=True)
    return folder


@contextmanager
def _no_bytecode() -> Iterator[None]:
    """Keep the interpreter from writing bytecode beside an FMU's modules: the entry of the cache is sealed."""
    before, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    try:
        yield
    finally:
        sys.dont_write_bytecode = before


class FmuSlave:
    """One instance of an FMU; not thread-safe by itself, so that threads that share it hold `lock`.

    Parameters
    ----------
    path
        Archive of the FMU.

    Raises
    ------
    NumericalError
        Where the FMU cannot be loaded or instantiated; the message is the FMU's own where it has one.
    """

    def __init__(self, path: Path) -> None:
        """Unpack, load and instantiate."""
        self.path, folder = path, unpack_fmu(path)
        self.description: ModelDescription = fmpy.read_model_description(str(folder))
        self.messages: list[str] = []
        self.lock = threading.Lock()
        together = self.description.coSimulation
        self.references = {v.name: int(v.valueReference) for v in self.description.modelVariables}
        try:
            self._slave = FMU2Slave(
                guid=self.description.guid,
                unzipDirectory=str(folder),
                modelIdentifier=together.modelIdentifier,
                instanceName=path.stem,
            )
            with _no_bytecode():
                self._slave.instantiate(loggingOn=True, callbacks=self._callbacks())
        except Exception as error:  # fmpy raises bare exceptions where a library or a slave does not come up
            msg = f"{path.name}: {self.messages[-1] if self.messages else error}"
            raise NumericalError(msg) from error
        self._functions = [ctypes.cast(getattr(self._slave.dll, name), ctypes.c_void_p) for name in FUNCTIONS]
        self._run = _driver(hold_lock=(folder / "resources" / "slavemodule.txt").exists())
        self._fresh = True

    def _callbacks(self) -> fmi2CallbackFunctions:
        def keep(_: object, _name: bytes, status: int, _category: bytes, message: bytes) -> None:
            del self.messages[:-KEPT_MESSAGES]
            self.messages.append(f"{message.decode(errors='replace')} (status {status})")

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(keep)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        return callbacks

    def initialise(
        self, start: Mapping[int, float], *, switches: Mapping[int, bool] | None = None, time: float = 0.0
    ) -> None:
        """Reset the slave, set its start values and go through FMI's initialization mode.

        Parameters
        ----------
        start
            Start values of real variables by value reference.
        switches
            Start values of boolean variables by value reference.
        time
            Start time [s].

        Raises
        ------
        NumericalError
            Where the FMU refuses a value.
        """
        if not self._fresh:
            self._slave.reset()
        self._fresh = False
        try:
            self._slave.setupExperiment(startTime=time)
            self._slave.enterInitializationMode()
            if switches:
                self._slave.setBoolean(list(switches), [bool(value) for value in switches.values()])
            self._slave.setReal(list(start), [float(value) for value in start.values()])
            self._slave.exitInitializationMode()
        except FMICallException as error:
            msg = f"{self.path.name}: {self.messages[-1] if self.messages else error}"
            raise NumericalError(msg) from error

    def run(
        self,
        t: Array,
        inputs: Sequence[int],
        values: Array,
        outputs: Sequence[int],
        *,
        step: float = THRESHOLDS.inner_step_s,
    ) -> Array:
        """Step from row to row, setting the inputs and reading the outputs.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        inputs, values
            Value references (n_inputs,) and what is set at each row, shape (n_t, n_inputs).
        outputs
            Value references, read at each row after its inputs are set.
        step
            Inner step of the FMU [s], from which follows how many rows go into one call.

        Returns
        -------
        ndarray, shape (n_t, n_outputs)
            Outputs; NaN from the row on at which the FMU failed.

        Raises
        ------
        ValueError
            Where ``values`` does not have the shape (n_t, n_inputs).
        NumericalError
            Where the FMU fails at its first row.
        """
        times, table = np.ascontiguousarray(t, dtype=np.float64), np.ascontiguousarray(values, dtype=np.float64)
        in_vr, out_vr = np.array(inputs, dtype=np.uint32), np.array(outputs, dtype=np.uint32)
        if table.shape != (times.size, in_vr.size):
            msg = f"values needs shape {(times.size, in_vr.size)}, got {table.shape}"
            raise ValueError(msg)
        result = np.full((times.size, out_vr.size), np.nan)
        done = 0
        # In pieces, because Python hears a signal only between calls of compiled code.
        for rows in pieces(times, step):
            size = rows.stop - rows.start
            done = self._run(
                *self._functions,
                self._slave.component,
                size,
                times[rows].ctypes.data,
                in_vr.size,
                in_vr.ctypes.data,
                table[rows].ctypes.data,
                out_vr.size,
                out_vr.ctypes.data,
                result[rows].ctypes.data,
            )
            if done < size:
                break
        if done == 0 and rows.start == 0:
            msg = f"{self.path.name}: {self.messages[-1] if self.messages else 'the FMU refused its first values'}"
            raise NumericalError(msg)
        return result
