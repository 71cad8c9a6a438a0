"""Workers by what the user asked for: an address of a scheduler and a number of processes in, `Workers` out."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from haptid.identification.workers.dask_workers import Cluster
from haptid.identification.workers.workers import Here, Processes, Workers


def workers_of(scheduler: str | None, count: int) -> AbstractContextManager[Workers]:
    """Return the workers of a job.

    Parameters
    ----------
    scheduler
        Address of a running Dask scheduler; processes on this machine where None.
    count
        Number of processes on this machine; 1 starts none, and works in this process.

    Returns
    -------
    context manager of Workers
        The workers live as long as the context.

    Raises
    ------
    InputError
        Where the scheduler cannot be reached, or the extra for clusters is not installed.
    """
    if scheduler is not None:
        return Cluster(scheduler)
    return Processes(count) if count > 1 else nullcontext(Here())
