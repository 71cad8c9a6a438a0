"""Lock of an output folder, so that one command at a time writes there.

The operating system releases the lock of a process that dies, so that no stale lock stops a later command.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import takewhile
from pathlib import Path

from haptid.support.errors import InputError
from haptid.support.files.files import remove_drafts, unwritable

NAME = ".haptid.lock"
"""The lock lies in the folder itself: whoever can write there sees it, from any machine and with any TMPDIR."""
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Lock ``folder`` against other commands within the block, and make it where it does not exist.

    At the end the lock's file is removed, and so are folders made here in which nothing was written: a command that
    refuses its input leaves nothing behind. A killed command leaves an empty file, which blocks no other command, and
    perhaps a draft, which the next command removes.

    Parameters
    ----------
    folder
        Folder to which the command writes.

    Raises
    ------
    InputError
        Where another command holds the lock, or the folder cannot be written.
    WritingError
        Where the disk is full or fails.
    """
    made = list(takewhile(lambda path: not path.exists(), (folder, *folder.absolute().parents)))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = _lock_file(folder)
        try:
            yield
        finally:
            _release(folder / NAME, descriptor)
    finally:
        with suppress(OSError):  # not empty, or not there
            for path in made:
                path.rmdir()


def _lock_file(folder: Path) -> int:
    """Return the descriptor of the lock's file, locked by this process and still at its path.

    The command before may remove the file between opening and locking; the lock would then protect nothing, and the
    loop opens the file anew.
    """
    path = folder / NAME
    while True:
        descriptor = _open_file(folder, path)
        try:
            _take(descriptor)
            if _is_at(path, descriptor):
                remove_drafts(folder)
                return descriptor
        except OSError as error:
            if error.errno in _NO_LOCKS:
                print(f"note: {folder}: no locks on this file system: run one command at a time", file=sys.stderr)
                return descriptor
            os.close(descriptor)
            raise _refuse_second(folder, "wait until it ends, or name another folder with --out") from None
        os.close(descriptor)  # the command before us took its lock away in between


def _open_file(folder: Path, path: Path) -> int:
    """Open the lock's file; a file of another user may only be readable, which suffices for a lock."""
    follow = getattr(os, "O_NOFOLLOW", 0)
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | follow, 0o666)
    except OSError as error:
        if not path.is_file() or path.is_symlink():
            raise unwritable(folder, error) from None
    try:
        return os.open(path, os.O_RDONLY | follow)
    except OSError:
        raise _refuse_second(folder, f"or remove {NAME} there, if no command runs any more") from None


def _refuse_second(folder: Path, todo: str) -> InputError:
    return InputError(str(folder), expected="one command at a time", got="another one is writing there", todo=todo)


def _is_at(path: Path, descriptor: int) -> bool:
    """Whether ``path`` is still the file behind ``descriptor``."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _release(path: Path, descriptor: int) -> None:
    if sys.platform == "win32":  # a file that is open cannot be removed there
        os.close(descriptor)
        with suppress(OSError):  # the next command has it already
            path.unlink()
        return
    with suppress(OSError):  # while it is still ours: who opened it meanwhile sees that the name is gone
        path.unlink()
    os.close(descriptor)


def _take(descriptor: int) -> None:
    """Take the lock, or raise OSError at once; closing the descriptor releases it."""
    if sys.platform == "win32":
        import msvcrt  # noqa: PLC0415 (there alone)

        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl  # noqa: PLC0415 (not there)

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
