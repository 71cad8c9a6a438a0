"""A foreign FMU in a process of its own: path in, `ForeignFmu` out, which turns inputs into outputs.

A crash, a hang or a print of the FMU cannot reach the command that runs it.
"""

from __future__ import annotations

import multiprocessing
import shutil
import signal
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn, Self

import numpy as np

from haptid.identification.foreign.archive import unpack_checked
from haptid.identification.foreign.child import Request, serve
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError, NumericalError


class ForeignFmu:
    """FMU 2.0 or 3.0 for co-simulation that runs in a child process; the next simulation replaces a child that ended.

    Parameters
    ----------
    path
        Archive of the FMU; it is checked and unpacked into a folder that `close` removes.
    limit_s
        Longest wait for one simulation [s].

    Raises
    ------
    InputError
        Where `identification.foreign.archive.unpack_checked` refuses the archive.
    """

    def __init__(self, path: Path, *, limit_s: float = THRESHOLDS.longest_simulation_s) -> None:
        self.path, self.limit_s = path, limit_s
        self._folder = Path(tempfile.mkdtemp(prefix="haptid_fmu_"))
        self._child: Any = None
        self._connection: Connection | None = None
        try:
            self._unpacked = unpack_checked(path, self._folder)
        except BaseException:
            self.close()
            raise
        self.variables = tuple(v.name for v in self._unpacked.description.modelVariables)

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close."""
        self.close()

    def simulate(
        self, t: Array, *, start: Mapping[str, float], inputs: Mapping[str, Array], outputs: Sequence[str]
    ) -> Array:
        """Step from row to row, setting the inputs and reading the outputs.

        Parameters
        ----------
        t
            Times of the rows [s], shape (n_t,).
        start
            Start values by variable.
        inputs
            Values that are set at each row by variable, shape (n_t,) each.
        outputs
            Variables that are read at each row after its inputs are set.

        Returns
        -------
        ndarray, shape (n_t, n_outputs)

        Raises
        ------
        InputError
            Where the FMU has no such variable.
        NumericalError
            Where the FMU reports an error, ends its process, gives no answer in time, or an output that is no number.
        """
        self._check([*start, *inputs, *outputs])
        request = Request(t=np.asarray(t, dtype=float), start=start, inputs=inputs, outputs=tuple(outputs))
        try:
            connection = self._start()
            connection.send(request)
            answer = self._answer(connection, self.limit_s, "no answer")
        except (EOFError, ConnectionError):
            self._child.join()
            self._fail(f"its own code ended the process ({_how(self._child.exitcode)})")
        if isinstance(answer, str):
            self._tell(answer)
        y = np.asarray(answer)
        broken = np.argwhere(~np.isfinite(y))
        if broken.size:
            row, column = broken[0]
            self._tell(f"its output {outputs[column]} is {y[row, column]} at t = {request.t[row]:g} s (row {row + 1})")
        return y

    def close(self) -> None:
        """End the child and remove the unpacked files."""
        self._stop()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _check(self, names: Iterable[str]) -> None:
        for name in names:
            if name not in self.variables:
                near = get_close_matches(name, self.variables, n=1) or sorted(self.variables)[:5]
                todo = f"is {near[0]!r} meant?" if len(near) == 1 else f"as {', '.join(near)}"
                raise InputError(str(self.path), expected="the name of a variable", got=repr(name), todo=todo)

    def _answer(self, connection: Connection, limit_s: float, what: str) -> Any:
        if not connection.poll(limit_s):
            self._fail(f"{what} within {limit_s:g} s: it was ended")
        return connection.recv()

    def _start(self) -> Connection:
        """Return the connection to a child that is ready: its beginning does not count as time of a simulation."""
        if self._connection is None:
            here, there = multiprocessing.Pipe()
            context = multiprocessing.get_context("spawn")
            self._child = context.Process(target=serve, args=(there, self._unpacked), daemon=True)
            self._child.start()
            there.close()
            self._connection = here
            self._answer(here, THRESHOLDS.longest_start_of_process_s, "its process was not ready")
        return self._connection

    def _fail(self, reason: str) -> NoReturn:
        self._stop()
        self._tell(reason)

    def _tell(self, reason: str) -> NoReturn:
        msg = f"{self.path.name}: {reason}"
        raise NumericalError(msg)

    def _stop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._child.kill()
            self._child.join()
        self._connection = None


def _how(code: int | None) -> str:
    return f"signal {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit code {code}"
