"""Worker processes on this machine: functions with arguments in, futures out.

Only the parent reacts to Ctrl-C and ends its workers, and never in the middle of a worker's start.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import resource_tracker
from types import TracebackType
from typing import Any, TypeVar

from haptid.support.interrupts import interrupts_held_back

T = TypeVar("T")
NICENESS = 10
"""Added to the niceness of a gentle worker [1], of which the most is 19."""


class Pool(ProcessPoolExecutor):
    """Pool of spawned worker processes, which start as tasks arrive and end with their parent, however it ends.

    Parameters
    ----------
    count
        Most workers.
    gentle
        Whether the workers give way to other processes, where the system knows of priorities.
    """

    def __init__(self, count: int, *, gentle: bool = False) -> None:
        _start_tracker()
        context = multiprocessing.get_context("spawn")
        super().__init__(count, mp_context=context, initializer=_left_to_the_parent, initargs=(gentle,))

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Start a task, with Ctrl-C held back while a worker may be starting.

        Parameters
        ----------
        fn
            Function that can be pickled.
        *args, **kwargs
            Its arguments.

        Returns
        -------
        Future
            Of the function's result.
        """
        with interrupts_held_back():
            return super().submit(fn, *args, **kwargs)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Shut down: drop tasks that have not begun; after an error or Ctrl-C end the running ones, too.

        Either way the interpreter has no worker to wait for at its end, where a second Ctrl-C would print a traceback.
        """
        for child in list((self._processes or {}).values()) if kind is not None else []:
            child.terminate()
        self.shutdown(cancel_futures=True)


def _start_tracker() -> None:
    """Start Python's tracker of semaphores without its warnings about semaphores of a killed command."""
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


def _left_to_the_parent(gentle: bool) -> None:
    """Initialise a worker: ignore Ctrl-C, since the parent ends its workers itself, and end where the parent dies."""
    if gentle and hasattr(os, "nice"):
        os.nice(NICENESS)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_the_parent()


def end_with_the_parent() -> None:
    """Watch the parent in a thread, and end this process where the parent ends, however that ends."""
    threading.Thread(target=_wait_for_the_parent, daemon=True).start()


def _wait_for_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
