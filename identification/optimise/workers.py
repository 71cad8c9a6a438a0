"""Workers of a fit: a function and its tasks in, results in the order of the tasks out.

Tasks run in this process, in processes of this machine, or on a Dask cluster; the results do not depend on the choice.
Results are taken in the order of the tasks, and the decision whether enough tasks are done uses the results so far in
that order, so that neither the number of workers nor their speed changes an outcome. BLAS runs single-threaded
everywhere: its sums would otherwise depend on the number of threads.
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
"""Function from the results so far to the smallest number of further results that are needed; 0 ends."""


class Workers(Protocol):
    """Runs functions of picklable arguments."""

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """Run tasks until enough are done.

        Parameters
        ----------
        function
            Function of a task's arguments; picklable where it runs in another process.
        tasks
            Arguments of the tasks, in their order.
        more
            Function from the results so far to the smallest number of further results that are needed.

        Returns
        -------
        list
            Results of the first tasks, in order, until ``more`` is 0 or all tasks are done.
        """


class Here:
    """Runs one task after the other in this process."""

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """Run tasks one after the other until enough are done.

        Parameters
        ----------
        function
            Function of a task's arguments.
        tasks
            Arguments of the tasks, in their order.
        more
            As in `Workers.until`.

        Returns
        -------
        list
            Results of the first tasks, in order.
        """
        results: list[T] = []
        for task in tasks:
            if more(results) <= 0:
                break
            results.append(single_threaded(function, *task))
        return results


class Submitting:
    """Takes results of futures in the order of the tasks; subclasses say how a task is submitted.

    ``count`` is the number of workers.
    """

    count: int

    def submit(self, function: Callable[..., T], *task: Any) -> Any:
        """Start a task and return its future.

        Parameters
        ----------
        function
            Function that the workers run.
        *task
            Its arguments.

        Returns
        -------
        Any
            Object with ``result()`` and ``cancel()``.

        Raises
        ------
        NotImplementedError
            Here: subclasses say how.
        """
        raise NotImplementedError

    def until(self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough) -> list[T]:
        """Run tasks until enough are done; as many tasks as there are workers run from the beginning.

        Parameters
        ----------
        function
            Function of a task's arguments.
        tasks
            Arguments of the tasks, in their order.
        more
            As in `Workers.until`.

        Returns
        -------
        list
            Results of the first tasks, in order; tasks beyond them are cancelled.
        """
        futures: list[Any] = []
        results: list[T] = []
        while (needed := more(results)) > 0 and len(results) < len(tasks):
            # Tasks beyond the needed ones keep all workers busy; their results are dropped where enough are done.
            ahead = min(max(self.count, len(results) + needed), len(tasks))
            futures += [self.submit(function, *task) for task in tasks[len(futures) : ahead]]
            results.append(futures[len(results)].result())
        for future in futures[len(results) :]:
            future.cancel()
        return results


class Processes(Submitting, AbstractContextManager["Processes"]):
    """Runs tasks in processes of this machine, which start with the first task.

    Parameters
    ----------
    count
        Number of processes.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: Pool | None = None

    def submit(self, function: Callable[..., T], *task: Any) -> Future[T]:
        """Start a task; the processes start with the first one.

        Parameters
        ----------
        function
            Function that can be pickled.
        *task
            Its arguments.

        Returns
        -------
        Future
            Result to come; the function runs with single-threaded BLAS.
        """
        if self._pool is None:
            self._pool = Pool(self.count)
        return self._pool.submit(single_threaded, function, *task)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop the tasks that have not begun; end the running ones after an error or Ctrl-C."""
        if self._pool is not None:
            self._pool.__exit__(kind, error, trace)
