"""Workers of a fit: a function and its tasks in, results in the order of the tasks out.

Tasks run in this process, in processes of this machine, or on a Dask cluster; the results do not depend on the choice.
Results are taken in the order of the tasks, and the decision whether enough tasks are done uses the results so far in
that order, so that neither the number of workers nor their speed changes an outcome. BLAS runs single-threaded
everywhere: its sums would otherwise depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from types import TracebackType
from typing import Any, Protocol, TypeVar

from haptid.support.processes.messages import Mailbox
from haptid.support.processes.pool import Pool
from haptid.support.processes.threads import single_threaded

T = TypeVar("T")
MESSAGES_EVERY_S = 0.2
"""Interval at which messages of tasks are taken [s]."""
Enough = Callable[[Sequence[Any]], int]
"""Function from the results so far to the smallest number of further results that are needed; 0 ends."""


Tell = Callable[[float, str], None]
"""Function that is told the share of a task that is done, from 0 to 1, and figures in words."""
Watch = Callable[[int, float, str], None]
"""The same for several tasks: number of the task, share and figures."""


def tell_nobody(share: float | None, figures: str) -> None:
    """Take how far a task is, and do nothing.

    Parameters
    ----------
    share
        Share that is done.
    figures
        Figures so far.
    """


def watch_nothing(task: int, share: float, figures: str) -> None:
    """Take how far a task of several is, and do nothing.

    Parameters
    ----------
    task
        Number of the task.
    share
        Share that is done.
    figures
        Figures so far.
    """


class Workers(Protocol):
    """Runs functions of picklable arguments."""

    def until(
        self,
        function: Callable[..., T],
        tasks: Sequence[tuple[Any, ...]],
        more: Enough,
        *,
        what: str = "",
        watch: Watch | None = None,
    ) -> list[T]:
        """Run tasks until enough are done.

        Parameters
        ----------
        function
            Function of a task's arguments; picklable where it runs in another process.
        tasks
            Arguments of the tasks, in their order.
        more
            Function from the results so far to the smallest number of further results that are needed.
        what
            What one task is, for those who wait.
        watch
            Told of each task how far it is; ``function`` then takes a `Tell` after the arguments of the task.

        Returns
        -------
        list
            Results of the first tasks, in order, until ``more`` is 0 or all tasks are done.
        """


class Here:
    """Runs one task after the other in this process."""

    def until(
        self,
        function: Callable[..., T],
        tasks: Sequence[tuple[Any, ...]],
        more: Enough,
        *,
        what: str = "",  # noqa: ARG002 (who tells, knows it)
        watch: Watch | None = None,
    ) -> list[T]:
        """See `Workers`."""
        results: list[T] = []
        for number, task in enumerate(tasks):
            if more(results) <= 0:
                break
            tell = () if watch is None else (partial(watch, number),)
            results.append(single_threaded(function, *task, *tell))
        return results


class Submitting:
    """Takes results of futures in the order of the tasks; subclasses say how a task is submitted.

    ``count`` is the number of workers; ``here`` says whether they run on this machine, where they can tell how far they
    are.
    """

    count: int
    here: bool = False

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

    def until(
        self,
        function: Callable[..., T],
        tasks: Sequence[tuple[Any, ...]],
        more: Enough,
        *,
        what: str = "",  # noqa: ARG002 (the same)
        watch: Watch | None = None,
    ) -> list[T]:
        """See `Workers`; as many tasks run as there are workers, and those beyond the needed ones are cancelled."""
        futures: list[Any] = []
        results: list[T] = []
        with nullcontext() if watch is None or not self.here else Mailbox() as mailbox:
            while (needed := more(results)) > 0 and len(results) < len(tasks):
                # Tasks beyond the needed ones keep all workers busy; their results are dropped where enough are done.
                ahead = min(max(self.count, len(results) + needed), len(tasks))
                for number in range(len(futures), ahead):
                    tell = () if mailbox is None else (mailbox.sender(number),)
                    futures.append(self.submit(function, *tasks[number], *tell))
                if mailbox is not None and watch is not None:
                    _watch_until_done(futures[len(results)], mailbox, watch)
                results.append(futures[len(results)].result())
        for future in futures[len(results) :]:
            future.cancel()
        return results


def _watch_until_done(future: Future[Any], mailbox: Mailbox, watch: Watch) -> None:
    """Hand on what the tasks tell until one of them is done."""
    done = False
    while not done:
        done = bool(wait([future], timeout=MESSAGES_EVERY_S).done)
        latest = {message.task: message for message in mailbox.messages()}  # only the last word of a task counts
        for message in latest.values():
            watch(message.task, message.share, message.figures)


class Processes(Submitting, AbstractContextManager["Processes"]):
    """Runs tasks in processes of this machine, which start with the first task.

    Parameters
    ----------
    count
        Number of processes.
    """

    here = True

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
