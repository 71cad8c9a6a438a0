"""Dask's client: address of a scheduler in, a connection that is closed even where it could not be made out.

Dask leaves a client that cannot connect to the garbage collector, whose call of ``close`` waits for a lock of all
clients for ever where the collector runs while another client holds it.
"""

from __future__ import annotations

from typing import Any

from distributed import Client


class DaskClient(Client):
    """`distributed.Client`, closed at once where its scheduler does not answer.

    Parameters
    ----------
    *arguments, **options
        As for `distributed.Client`: the scheduler's address first.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        try:
            super().__init__(*arguments, **options)
        except BaseException:
            self.close()
            raise
