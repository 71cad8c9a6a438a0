"""Where the starts of a fit run: here, in processes, or on a Dask cluster. The results do not depend on which.

Tasks are consumed in their order, and whether enough are done is decided on the results so far in that order, so that
neither the number of workers nor their speed can change an outcome. BLAS runs single-threaded everywhere: its sums
would otherwise depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, Protocol, TypeVar

from haptid.support.processes.pool import Pool
from haptid.support.processes.threads import single_threaded

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


class Processes(Submitting, AbstractContextManager["Processes"]):
    """Processes on this machine, started on first use."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: Pool | None = None

    def submit(self, function: Callable[..., T], *task: Any) -> Future[T]:
        """Start a task."""
        if self._pool is None:
            self._pool = Pool(self.count)
        return self._pool.submit(single_threaded, function, *task)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop: what has not begun is dropped, what runs is ended where an error or Ctrl-C came."""
        if self._pool is not None:
            self._pool.__exit__(kind, error, trace)
