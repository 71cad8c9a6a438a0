"""The same tasks on a running Dask cluster; a lost worker costs its own tasks, which run again elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any

from identification.workers import Submitting
from support.errors import InputError
from support.threads import single_threaded

PROBE = f"import {__name__}"


class Cluster(Submitting, AbstractContextManager["Cluster"]):
    """A client of the scheduler at ``address`` (``tcp://host:port``)."""

    def __init__(self, address: str) -> None:
        from distributed import Client  # noqa: PLC0415 (slow to import and rarely needed)

        try:
            self._client = Client(address, timeout="10s", set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                "--scheduler", expected="the address of a running Dask scheduler", got=f"{address}: {error}"
            ) from None
        try:
            for run in (self._client.run_on_scheduler, self._client.run):
                run(exec, PROBE)
        except ImportError as error:
            self._client.close()
            raise InputError(
                "--scheduler", expected="a scheduler and workers that can import haptid", got=f"{address}: {error}",
                todo="start them in haptid's environment, with its folder as working directory or in PYTHONPATH",
            ) from None  # fmt: skip
        self.count = max(len(self._client.scheduler_info()["workers"]), 1)

    def submit(self, function: Callable[..., Any], *task: Any) -> Any:
        """Start a task; it is tried again where its worker is lost."""
        return self._client.submit(single_threaded, function, *task, retries=3, pure=False)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disconnect."""
        self._client.close()
