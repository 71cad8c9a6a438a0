"""Files that are written whole or not at all, and JSON that is read with an error a user can act on."""

from __future__ import annotations

import errno
import json
import os
import secrets
from pathlib import Path
from typing import Any

from haptid.support.errors import HaptidError, InputError
from haptid.support.files.data import parse_json
from haptid.support.files.json_schema import check_content

LARGEST_FILE = 100_000_000
"""Bytes of a JSON file that is read; the result of a campaign of 500 runs has a hundredth of it."""
NOT_ALLOWED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


written: list[Path] = []
"""What this process has written whole, for what is said where it ends early."""


class WritingError(HaptidError):
    """A file could not be written (exit code 1): a full disk, a quota, a device that failed."""


def is_file(path: Path) -> bool:
    """Whether ``path`` is a file; a name that no file can have (too long, with NUL) is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def write_bytes(path: Path, data: bytes) -> Path:
    """Write ``data`` to ``path`` through a temporary file in the same folder and an atomic rename.

    The bytes are on the disk before the name is; what may read and write the file is the user's umask.

    Raises
    ------
    InputError
        Where nobody lets us write there (exit code 2).
    WritingError
        Where the disk is full or fails.
    """
    draft = path.parent / f".{path.name[:40]}.{secrets.token_hex(6)}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write_through(draft, data)
        draft.replace(path)
        _sync_folder(path.parent)
        written.append(path)
    except OSError as error:
        _forget(draft)
        raise unwritable(path, error) from None
    except BaseException:
        _forget(draft)
        raise
    return path


def unwritable(path: Path, error: OSError) -> HaptidError:
    """Return the error that says in one line why ``path`` could not be written."""
    reason = error.strerror or str(error)
    if error.errno in NOT_ALLOWED:
        todo = "name another folder, or change who may write there"
        return InputError(str(path), expected="a place that can be written", got=reason, todo=todo)
    return WritingError(f"{path}: could not be written ({reason}); free some space or name another folder, then repeat")


def check_writable(folder: Path) -> None:
    """Try with a small file whether ``folder`` can be made and written, before any work is done; nothing is left.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    there = next((path for path in (folder, *folder.absolute().parents) if path.exists()), folder)
    if not there.is_dir():
        raise InputError(str(folder), expected="a folder", got=f"the file {there}", todo="name another one")
    probe = there / f".probe.{secrets.token_hex(6)}"
    try:
        probe.write_bytes(b"probe")
    except OSError as error:
        raise unwritable(folder, error) from None
    finally:
        _forget(probe)


def _write_through(path: Path, data: bytes) -> None:
    """Write a new file and wait until the disk has it; its mode is 0666 less the umask."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    with os.fdopen(descriptor, "wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def _sync_folder(folder: Path) -> None:
    """Wait until the disk has the new name, where the system can be asked for that."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # some network file systems have no such call
            raise
    finally:
        os.close(descriptor)


def _forget(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:  # where nothing could be written there is nothing to take away
        return


def write_text(path: Path, text: str) -> Path:
    """Write ``text`` as UTF-8, whole or not at all; what UTF-8 has no bytes for (parts of a path, say) becomes "?"."""
    return write_bytes(path, text.encode(errors="replace"))


def write_json(path: Path, value: dict[str, Any]) -> Path:
    """Write ``value`` as indented JSON (NaN is refused), whole or not at all."""
    return write_text(path, json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def read_json(path: Path, wanted: str, schema: tuple[str, str] | None = None) -> dict[str, Any]:
    """Return the object that a JSON file holds; ``wanted`` says in words what it should be.

    Parameters
    ----------
    path
        The file.
    wanted
        What the file should be, as in ``an identification.json``.
    schema
        Package and file name of the JSON Schema that it follows; only the outermost level is checked where None.

    Raises
    ------
    InputError
        Where the file cannot be read, is no JSON, holds no object, or does not follow the schema.
    """
    try:
        text = read_content(path, wanted).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(str(path), expected="text in UTF-8", got=f"{error.reason} at byte {error.start}") from None
    data = parse_json(text, str(path), wanted)
    if not isinstance(data, dict):
        raise InputError(str(path), expected=f"{wanted}, a table {{ … }}", got=type(data).__name__)
    if schema is not None:
        check_content(data, str(path), wanted, schema)
    return data


def read_content(path: Path, wanted: str) -> bytes:
    """Return the bytes of a regular file: a pipe would be waited for, a huge one fill the memory.

    Raises
    ------
    InputError
        Where there is no such file, or it has more than `LARGEST_FILE` bytes; ``wanted`` says what it should be.
    """
    try:
        if path.exists() and not path.is_file():
            raise InputError(str(path), expected=f"{wanted}, a file", got="a folder or a device")
        if (size := path.stat().st_size) > LARGEST_FILE:
            raise InputError(str(path), expected=f"{wanted} of at most {LARGEST_FILE:.0e} bytes", got=f"{size} bytes")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(str(path), expected=f"{wanted} that can be read", got=reason_of(error)) from None


def reason_of(error: Exception) -> str:
    """Return why a file could not be read, without its path, which the message names already."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
