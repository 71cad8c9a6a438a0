"""Processes on this machine; Ctrl-C is the parent's, which ends them, and never in the middle of a worker's start."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker
from types import TracebackType
from typing import Any, TypeVar

T = TypeVar("T")
_ENDING = (signal.SIGINT, signal.SIGTERM)


class Pool(ProcessPoolExecutor):
    """Spawned workers, started as tasks come; they end with their parent, also where an error or Ctrl-C ends it."""

    def __init__(self, count: int) -> None:
        _start_tracker()
        super().__init__(count, mp_context=multiprocessing.get_context("spawn"), initializer=_left_to_the_parent)

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Start a task."""
        with interrupts_held_back():
            return super().submit(fn, *args, **kwargs)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop: what has not begun is dropped, what runs is ended where an error or Ctrl-C came.

        Either way nothing is left to wait for when the interpreter ends, where a second Ctrl-C would be told at length.
        """
        for child in list((self._processes or {}).values()) if kind is not None else []:
            child.terminate()
        self.shutdown(cancel_futures=True)


def _start_tracker() -> None:
    """Start Python's tracker of semaphores such that it says nothing of those that a killed command left to it."""
    if os.name != "posix":
        return
    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (before, "ignore:resource_tracker:UserWarning")))
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


def _left_to_the_parent() -> None:
    """Leave Ctrl-C to the parent, which ends its workers itself; end with a parent that was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back until the end; processes started meanwhile never see Ctrl-C.

    Their masks are this thread's, and they import for seconds before they can ask for one. The mask alone keeps nothing
    from this process: the system hands the signal to any other thread (a progress bar's, BLAS's), and Python then
    interrupts the main thread all the same, between a worker's start and what is written to it.
    """
    late: list[int] = []
    ours = _ENDING if threading.current_thread() is threading.main_thread() else ()
    before = {number: handler for number in ours if callable(handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, lambda number, _frame: late.append(number))
    try:
        with _masked():
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if late:
            signal.raise_signal(late[0])


@contextmanager
def _masked() -> Iterator[None]:
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
