"""Where the starts of a fit run: here, in processes, or on a Dask cluster. The results do not depend on which.

Tasks are consumed in their order, and whether enough are done is decided on the results so far in that order, so that
neither the number of workers nor their speed can change an outcome. BLAS runs single-threaded everywhere: its sums
would otherwise depend on the number of threads.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from threading import Thread
from types import TracebackType
from typing import Any, Protocol, TypeVar

from support.threads import single_threaded

T = TypeVar("T")
Enough = Callable[[Sequence[Any]], int]
"""From the results so far, how many more are needed at least; 0 ends."""


class Workers(Protocol):
    """Runs functions of picklable arguments."""

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """Return the results of the first tasks, as many as ``more`` asks for."""


class Here:
    """One task after the other in this process."""

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """See `Workers`."""
        results: list[T] = []
        for task in tasks:
            if more(results) <= 0:
                break
            results.append(single_threaded(function, *task))
        return results


class Submitting:
    """In-order consumption over anything that returns futures; subclasses say how to submit and to drop."""

    count: int

    def submit(self, function: Callable[..., T], *task: Any) -> Any:
        """Start a task and return its future."""
        raise NotImplementedError

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """See `Workers`; as many tasks as there are workers are under way from the start."""
        futures: list[Any] = []
        results: list[T] = []
        while (needed := more(results)) > 0 and len(results) < len(tasks):
            ahead = min(max(self.count, len(results) + needed), len(tasks))
            futures += [self.submit(function, *task) for task in tasks[len(futures) : ahead]]
            results.append(futures[len(results)].result())
        for future in futures[len(results) :]:
            future.cancel()
        return results


def _left_to_the_parent() -> None:
    """Leave Ctrl-C to the parent, which ends its workers itself; end with a parent that was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_the_parent, daemon=True).start()


def _end_with_the_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Hold Ctrl-C back; processes that are started meanwhile keep it so: they import for seconds before they can."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Processes(Submitting, AbstractContextManager["Processes"]):
    """Processes on this machine, started on first use."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, function: Callable[..., T], *task: Any) -> Future[T]:
        """Start a task."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(
                self.count, mp_context=multiprocessing.get_context("spawn"), initializer=_left_to_the_parent
            )
        with _interrupts_held_back():
            return self._pool.submit(single_threaded, function, *task)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop: what has not begun is dropped, what runs is ended where an error or Ctrl-C came."""
        if self._pool is None:
            return
        children = list(getattr(self._pool, "_processes", {}).values()) if kind is not None else []
        self._pool.shutdown(wait=kind is None, cancel_futures=True)
        for child in children:
            child.terminate()
