"""One command at a time writes into a folder; the system takes the lock from a process that dies, however it does."""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from haptid.support.errors import InputError


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold ``folder`` against other commands of this user on this machine.

    The lock lies beside the system's temporary files, so that a command that refuses its input leaves nothing behind.

    Raises
    ------
    InputError
        Where another command holds it.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    name = hashlib.sha256(str(folder.resolve()).encode(errors="surrogateescape")).hexdigest()[:24]
    path = Path(tempfile.gettempdir()) / f"haptid-{user}-{name}.lock"
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
    try:
        try:
            _take(descriptor)
        except OSError:
            todo = "wait until it ends, or name another folder with --out"
            raise InputError(
                str(folder), expected="one command at a time", got="another one is writing there", todo=todo
            ) from None
        yield
    finally:
        os.close(descriptor)


def _take(descriptor: int) -> None:
    """Take the lock or raise OSError at once; it ends with the descriptor."""
    if sys.platform == "win32":
        import msvcrt  # noqa: PLC0415 (there alone)

        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl  # noqa: PLC0415 (not there)

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
