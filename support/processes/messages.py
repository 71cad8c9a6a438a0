"""How far the tasks of other processes are: `Mailbox` in the process that waits, a `Sender` with each task.

Messages go as datagrams over this machine's loopback. A datagram waits for nobody: a worker that is killed leaves no
lock behind, one that is fast is not slowed down, and a message that is lost costs nothing, since the next says more.
"""

from __future__ import annotations

import json
import secrets
import socket
from collections.abc import Iterator
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from types import TracebackType

LONGEST_MESSAGE = 2000
"""Longest message [bytes]; what is longer is not sent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """How far a task is.

    Parameters
    ----------
    task
        Number of the task.
    share
        Share that is done, from 0 to 1.
    figures
        Figures so far.
    """

    task: int
    share: float
    figures: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sender:
    """Sends how far a task is; picklable.

    Parameters
    ----------
    port
        Port of the mailbox.
    token
        Word that the mailbox takes messages with.
    task
        Number of the task.
    """

    port: int
    token: str
    task: int

    def __call__(self, share: float, figures: str) -> None:
        """Send a message, or lose it.

        Parameters
        ----------
        share
            Share that is done, from 0 to 1.
        figures
            Figures so far.
        """
        data = json.dumps([self.token, self.task, share, figures]).encode()
        if len(data) > LONGEST_MESSAGE:
            return
        with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            out.setblocking(False)
            out.sendto(data, ("127.0.0.1", self.port))


class Mailbox(AbstractContextManager["Mailbox"]):
    """Takes messages until the end of the block; takes none where this machine has no loopback."""

    def __init__(self) -> None:
        self._token = secrets.token_hex(8)
        self._socket: socket.socket | None = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(("127.0.0.1", 0))
            self._socket.setblocking(False)
        except OSError:
            self.close()

    def sender(self, task: int) -> Sender:
        """Return what a task sends its messages with.

        Parameters
        ----------
        task
            Number of the task.

        Returns
        -------
        Sender
        """
        port = 0 if self._socket is None else self._socket.getsockname()[1]
        return Sender(port=port, token=self._token, task=task)

    def messages(self) -> Iterator[Message]:
        """Take the messages that have come so far.

        Yields
        ------
        Message
            In the order of their arrival; what others send to this port is dropped.
        """
        while self._socket is not None:
            try:
                data = self._socket.recv(LONGEST_MESSAGE)
            except OSError:  # nothing is there
                return
            with suppress(ValueError, TypeError):
                token, task, share, figures = json.loads(data)
                if token == self._token:
                    yield Message(task=int(task), share=float(share), figures=str(figures))

    def close(self) -> None:
        """Take no further messages."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take no further messages."""
        self.close()
