"""Compilation ahead of need: `Job` in, what its later configurations will run out, made while earlier ones are fitted.

What a configuration compiles depends on its formulas alone, which a device gives before the first fit. A thread has
them compiled one after the other and leaves FMUs and kernels in the cache, where the fits find them: the compiler runs
in processes of its own, while this process waits for its workers. The results are the same without it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import partial
from types import TracebackType
from typing import Any

from haptid.identification.job.job import Job
from haptid.identification.sequence.configurations import Configuration
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.model.device.device import Device
from haptid.model.joint.coupled_joints import configuration_equations
from haptid.model.joint.whole_device import full_equations
from haptid.model.kernel.cache import cached_kernel

Task = Callable[[], Any]


class Ahead(AbstractContextManager["Ahead"]):
    """Runs tasks in a thread, one after the other, whose results stay in the cache.

    Parameters
    ----------
    tasks
        Tasks in the order in which their results are needed.
    """

    def __init__(self, tasks: Sequence[Task]) -> None:
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="ahead")
        self._futures: list[Future[Any]] = [self._pool.submit(task) for task in tasks]

    def wait(self, number: int) -> None:
        """Wait for a task that has begun; one that has not is dropped, and left to whoever needs its result.

        Parameters
        ----------
        number
            Number of the task, from 0; there may be none of that number.
        """
        if number < len(self._futures) and not self._futures[number].cancel():
            # Where it failed, the stage that needs the result fails as well, and says of what.
            self._futures[number].exception()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Drop the tasks that have not begun, and wait for the one that runs."""
        self._pool.shutdown(cancel_futures=True)


def compilations_of(job: Job) -> list[Task]:
    """List what the configurations of an identification compile.

    Parameters
    ----------
    job
        What to identify, and how.

    Returns
    -------
    list of callable
        One task a configuration, in their order, and one for the whole device. None at all for single joints, whose
        formulas depend on their data, and where this process works alone.
    """
    if job.device is None or job.options.workers == 1 or job.scheduler is not None:
        return []
    each = [partial(_compile, job, job.device, one) for one in job.configurations]
    return [*each, partial(_compile_whole, job.device)]


def _compile(job: Job, device: Device, configuration: Configuration) -> None:
    """Compile what the fit of a configuration runs, and what holds the fit against the plain model."""
    free = configuration.free_joints
    drive = job.campaign.drives.get(free[0]) if len(free) == 1 else None
    equations = configuration_equations(device, free, configuration.posture, drive=drive)
    job.build(equations)
    KernelSimulator.of(equations)


def _compile_whole(device: Device) -> None:
    cached_kernel(full_equations(device))
