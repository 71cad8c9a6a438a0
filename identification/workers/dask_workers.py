"""Workers of a fit on a running Dask cluster: address of the scheduler in, `Cluster` out.

The tasks of a lost worker run again on another one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, TypeVar
from urllib.parse import urlsplit

import click

from haptid.identification.workers.workers import Enough, Submitting, Watch
from haptid.support.errors import InputError, NumericalError
from haptid.support.installing.extras import need
from haptid.support.processes.threads import single_threaded

T = TypeVar("T")
PROBE = f"import {__name__}"
"""Statement that scheduler and workers must be able to run."""
LOCAL = ("localhost", "127.0.0.1", "::1")
"""Names of this machine, to which an unencrypted connection needs no warning."""
CERTIFICATES = "name ca-file, client.cert and client.key under distributed.comm.tls in Dask's configuration"


class Cluster(Submitting, AbstractContextManager["Cluster"]):
    """Runs tasks on the workers of a Dask scheduler.

    Parameters
    ----------
    address
        ``tls://host:port``, with the certificates that Dask's configuration names, or ``tcp://host:port``, unencrypted.

    Raises
    ------
    InputError
        Where the address is malformed, no scheduler answers, certificates are missing, or haptid cannot be imported
        there.
    """

    def __init__(self, address: str) -> None:
        need("cluster", "--scheduler")
        encrypted = _is_encrypted(address)
        from haptid.identification.workers.dask_client import DaskClient  # noqa: PLC0415 (slow, rarely needed)

        try:
            self._client = DaskClient(address, timeout="10s", set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:  # TypeError: Dask's word for no certificate
            raise InputError(
                "--scheduler", expected="the address of a running Dask scheduler", got=f"{address}: {error}",
                todo=CERTIFICATES if encrypted else "",
            ) from None  # fmt: skip
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
        """Start a task; Dask tries the task again where its worker is lost.

        Parameters
        ----------
        function
            Function that can be pickled.
        *task
            Its arguments.

        Returns
        -------
        distributed.Future
            Result to come; the function runs with single-threaded BLAS.
        """
        return self._client.submit(single_threaded, function, *task, retries=3, pure=False)

    def until(
        self,
        function: Callable[..., T],
        tasks: Sequence[tuple[Any, ...]],
        more: Enough,
        *,
        what: str = "",
        watch: Watch | None = None,
    ) -> list[T]:
        """See `identification.workers.workers.Workers`.

        Raises
        ------
        NumericalError
            Where workers die of a task again and again, or the scheduler is gone.
        """
        from distributed import KilledWorker  # noqa: PLC0415 (as above)

        try:
            return super().until(function, tasks, more, what=what, watch=watch)
        except KilledWorker:
            msg = "--scheduler: workers of the cluster were killed by one task again and again; give them more memory"
            raise NumericalError(msg) from None
        except CancelledError:
            msg = "--scheduler: the scheduler is gone; what was finished is kept, start it again and repeat"
            raise NumericalError(msg) from None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disconnect."""
        self._client.close()


def _is_encrypted(address: str) -> bool:
    """Check the address and return whether it is encrypted; warn of an unencrypted one that leaves this machine."""
    try:
        parts = urlsplit(address)
        scheme, host, port = parts.scheme, parts.hostname, parts.port
    except ValueError:
        scheme, host, port = "", None, None
    if scheme not in ("tcp", "tls") or not host or port is None:
        raise InputError("--scheduler", expected="tls://HOST:PORT or tcp://HOST:PORT", got=address)
    if scheme == "tcp" and host not in LOCAL:
        click.echo(
            f"warning: --scheduler {address} is not encrypted: whoever is on the way reads the measurements and can "
            f"run code here and on the workers; use tls://{host}:{port}", err=True,
        )  # fmt: skip
    return scheme == "tls"
