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

from haptid.identification.foreign.archive import Unpacked, unpack_checked
from haptid.identification.foreign.child import serve
from haptid.identification.foreign.co_simulation import Request
from haptid.identification.foreign.variables import variables_of
from haptid.identification.thresholds import THRESHOLDS
from haptid.measurement.values.run import Array
from haptid.support.errors import InputError, NumericalError

_of_this_process: dict[Path, ForeignFmu] = {}
"""FMUs that came from another process, by the folder of their files."""


class ReportedError(NumericalError):
    """A simulation that the FMU refused or left with numbers that are not finite: other parameters may do."""


class ForeignFmu:
    """FMU 2.0 or 3.0 that runs in a child process; the next simulation replaces a child that ended.

    A copy in another process (by pickle) has a child of its own and the same unpacked files.

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
        self._simulated = 0
        self._connection: Connection | None = None
        try:
            self._bind(unpack_checked(path, self._folder))
        except BaseException:
            self.close()
            raise

    def _bind(self, unpacked: Unpacked) -> None:
        self._unpacked = unpacked
        self.variables = variables_of(unpacked.description)

    def __reduce__(self) -> tuple[object, ...]:
        """Cross process boundaries as the unpacked files."""
        return (_adopt, (self._unpacked, self.limit_s))

    @property
    def description(self) -> Any:
        """Model description as fmpy read it."""
        return self._unpacked.description

    @property
    def broken_rules(self) -> tuple[str, ...]:
        """Rules of the FMI standard that its description breaks, beyond the schema."""
        return self._unpacked.broken_rules

    @property
    def interface(self) -> str:
        """Interface that is simulated: ``CoSimulation`` or ``ModelExchange``."""
        return self._unpacked.interface

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Close."""
        self.close()

    def start(self) -> None:
        """Start the child process where there is none; `simulate` does so, too.

        Raises
        ------
        NumericalError
            Where the FMU cannot be loaded.
        """
        self._start()

    def simulate(
        self,
        t: Array,
        *,
        start: Mapping[str, float],
        inputs: Mapping[str, Array],
        outputs: Sequence[str],
        linear: bool = False,
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
        linear
            Whether the inputs are linear between rows; else they hold.

        Returns
        -------
        ndarray, shape (n_t, n_outputs)
            Outputs in the units of their variables.

        Raises
        ------
        InputError
            Where the FMU has no such variable.
        ReportedError
            Where the FMU reports an error, or gives an output that is no number.
        NumericalError
            Where the FMU ends a fresh process, or gives no answer in time.
        """
        self._check([*start, *inputs, *outputs])
        request = Request(
            t=np.asarray(t, dtype=float), start=start, inputs=inputs, outputs=tuple(outputs), linear=linear
        )
        answer = self._ask(request)
        if isinstance(answer, str):
            raise ReportedError(self._message_of(answer))
        y = np.asarray(answer)
        broken = np.argwhere(~np.isfinite(y))
        if broken.size:
            row, column = broken[0]
            at = f"at t = {request.t[row]:g} s (row {row + 1})"
            raise ReportedError(self._message_of(f"its output {outputs[column]} is {y[row, column]} {at}"))
        return y

    def _ask(self, request: Request) -> Any:
        """Return a child's answer. One that has simulated before may end of that, so that a fresh one is asked again.

        OpenModelica's FMUs take a key of the thread library at each loading and keep it: a process has 1,024 of them.
        """
        while True:
            try:
                connection = self._start()
                connection.send(request)
                answer = self._answer(connection, self.limit_s, "no answer")
            except (EOFError, ConnectionError):
                self._child.join()
                if not self._simulated:
                    self._fail(f"its own code ended the process ({_how(self._child.exitcode)})")
                self._stop()
            else:
                self._simulated += 1
                return answer

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
            self._fail(f"{what} within {limit_s:g} s: it was ended; raise --simulation-limit where it is only slow")
        return connection.recv()

    def _start(self) -> Connection:
        """Return the connection to a child that is ready: its beginning does not count as time of a simulation."""
        if self._connection is None:
            here, there = multiprocessing.Pipe()
            context = multiprocessing.get_context("spawn")
            self._child = context.Process(target=serve, args=(there, self._unpacked), daemon=True)
            self._child.start()
            there.close()
            self._connection, self._simulated = here, 0
            self._answer(here, THRESHOLDS.longest_start_of_process_s, "its process was not ready")
        return self._connection

    def _fail(self, reason: str) -> NoReturn:
        self._stop()
        raise NumericalError(self._message_of(reason))

    def _message_of(self, reason: str) -> str:
        return f"{self.path.name}: {reason}"

    def _stop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._child.kill()
            self._child.join()
        self._connection = None


def _adopt(unpacked: Unpacked, limit_s: float) -> ForeignFmu:
    """Return the FMU of this process with these files; its process and not this one removes them."""
    found = _of_this_process.get(unpacked.folder)
    if found is None:
        found = ForeignFmu.__new__(ForeignFmu)
        found.path, found.limit_s, found._folder = unpacked.path, limit_s, unpacked.folder
        found._child, found._simulated, found._connection = None, 0, None
        found._bind(unpacked)
        _of_this_process[unpacked.folder] = found
    return found


def _how(code: int | None) -> str:
    return f"signal {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit code {code}"
