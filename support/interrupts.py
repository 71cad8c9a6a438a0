"""What Ctrl-C and SIGTERM do to a command: end it in one line before it has begun, raise while it runs, or wait.

Standard library only, because it acts before anything else is imported.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

INTERRUPTED, TERMINATED = 130, 143
"""Exit codes that shells give to commands ended by SIGINT and SIGTERM: 128 plus the signal's number."""
Handler = Callable[[int, FrameType | None], Any]
_ENDING = (signal.SIGINT, signal.SIGTERM)


class Terminated(KeyboardInterrupt):
    """SIGTERM, as ``timeout``, a batch system or a container sends it: a command ends as it does on Ctrl-C."""


def end_at_interrupt() -> None:
    """Let Ctrl-C end this process at once, in one line, until a command begins: no command has written anything yet.

    An exception could not: modules are imported all the time, and Python drops what is raised in the callbacks of its
    import locks. A process that ignores Ctrl-C, as one in a shell's background does, goes on ignoring it.
    """
    if _is_main() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    os.write(2, b"interrupted: nothing was finished yet\n")  # the interpreter's own stream may be at work
    os._exit(INTERRUPTED)


@contextmanager
def interrupts_raise() -> Iterator[None]:
    """Let Ctrl-C raise `KeyboardInterrupt` and SIGTERM `Terminated` within the block, and Ctrl-C after it as well."""
    if not _is_main():  # Python sets signal handlers there only
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        raise Terminated

    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def no_interrupt_is_lost() -> Iterator[None]:
    """Raise at the end of the block, once more, what Ctrl-C or SIGTERM raised within and nobody heard.

    Python drops what is raised in the callback of a weak reference, which each import runs, and imported modules may
    catch it where they try what is there, or turn it into an error of their own.
    """
    lost: list[int] = []

    def remembering(handler: Handler) -> Handler:
        def handle(number: int, frame: FrameType | None) -> Any:
            lost.append(number)
            return handler(number, frame)

        return handle

    def tell(dropped: Any) -> None:  # Python's own words about it are a traceback
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            before(dropped)

    before, sys.unraisablehook = sys.unraisablehook, tell
    try:
        with _handlers_replaced(remembering):
            yield
    except Exception:  # an extension module in C fails where it is interrupted, by an error of its own
        if not lost:
            raise
    finally:
        sys.unraisablehook = before
    if lost:
        signal.raise_signal(lost[0])


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back until the end of the block; processes started within never see Ctrl-C.

    Notes
    -----
    A new process inherits this thread's signal mask. It imports for seconds before it can set one itself, so the mask
    has to be in place at its start. The mask alone does not protect this process: the system delivers the signal to
    another thread (of a progress bar or BLAS), and Python then interrupts the main thread all the same, between the
    start of a worker and the data that are written to it. So the handlers are replaced as well.
    """
    late: list[int] = []
    try:
        with _handlers_replaced(lambda _: lambda number, _frame: late.append(number)), _mask_interrupts():
            yield
    finally:
        if late:  # the signal acts now, by the handler that is back in place
            signal.raise_signal(late[0])


@contextmanager
def _mask_interrupts() -> Iterator[None]:
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _handlers_replaced(other: Callable[[Handler], Handler]) -> Iterator[None]:
    """Replace the handlers of Ctrl-C and SIGTERM within the block, where they are Python's, by what ``other`` makes."""
    ours = _ENDING if _is_main() else ()
    before = {number: handler for number in ours if callable(handler := signal.getsignal(number))}
    for number, handler in before.items():
        signal.signal(number, other(handler))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()
