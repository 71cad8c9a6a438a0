"""Files: bytes, text or values in, written whole or not at all; JSON objects out, with errors a user can act on."""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
from pathlib import Path
from typing import Any

from haptid.support.errors import HaptidError, InputError
from haptid.support.files.data import parse_json
from haptid.support.files.json_schema import check_content

LARGEST_FILE = 100_000_000
"""Most bytes of a JSON file that is read; the result of a campaign of 500 runs has a hundredth of them."""
NOT_ALLOWED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)
"""Codes of writing errors for which another place is the remedy, and not free space."""


written: list[Path] = []
"""Files that this process has written whole, for the message where a command ends early."""


class WritingError(HaptidError):
    """A file could not be written (exit code 1): a full disk, a quota, a device that failed."""


DRAFT = ".haptid-draft"
"""End of the name under which a file is written before it takes its own."""
_NAME_OF_DRAFT = re.compile(rf"\..{{1,40}}\.[0-9a-f]{{12}}{re.escape(DRAFT)}")


def is_file(path: Path) -> bool:
    """Return whether a path is a file; a name that no file can have (too long, with NUL) is none.

    Parameters
    ----------
    path
        Path to look at.

    Returns
    -------
    bool
        False too where it cannot be examined.
    """
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def write_bytes(path: Path, data: bytes) -> Path:
    """Write a file through a temporary file in the same folder and an atomic rename.

    Parameters
    ----------
    path
        File to write; its folder is made where it is missing, its permissions follow the umask.
    data
        Content.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    InputError
        Where the place cannot be written (exit code 2).
    WritingError
        Where the disk is full or fails (exit code 1).
    """
    draft = path.parent / f".{path.name[:40]}.{secrets.token_hex(6)}{DRAFT}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write_through(draft, data)  # on the disk before the name is: a crash leaves no half file
        draft.replace(path)
        _sync_folder(path.parent)
        written.append(path)
    except OSError as error:
        _forget(draft)
        raise unwritable(path, error) from None
    except BaseException:  # Ctrl-C, too, leaves no draft behind
        _forget(draft)
        raise
    return path


def remove_drafts(folder: Path) -> None:
    """Remove what killed commands left of `write_bytes` in a folder that no other command writes to.

    Parameters
    ----------
    folder
        Folder of results, locked by the caller.
    """
    for draft in folder.glob(f".*{DRAFT}"):
        if _NAME_OF_DRAFT.fullmatch(draft.name):
            _forget(draft)


def unwritable(path: Path, error: OSError) -> HaptidError:
    """Return the error of a file that could not be written.

    Parameters
    ----------
    path
        File or folder.
    error
        Error of the system.

    Returns
    -------
    HaptidError
        `InputError` where another place is the remedy (`NOT_ALLOWED`), else `WritingError`.
    """
    reason = error.strerror or str(error)
    if error.errno in NOT_ALLOWED:
        todo = "name another folder, or change who may write there"
        return InputError(str(path), expected="a place that can be written", got=reason, todo=todo)
    return WritingError(f"{path}: could not be written ({reason}); free some space or name another folder, then repeat")


def check_writable(folder: Path) -> None:
    """Try with a small file whether ``folder`` can be made and written; the file is removed again.

    A command calls it before its work, so that hours of it are not lost at the first file.

    Parameters
    ----------
    folder
        Folder to write to; it need not exist.

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
    """Write a text as UTF-8, whole or not at all; a character that UTF-8 cannot encode (of a path, say) becomes "?".

    Parameters
    ----------
    path
        File to write; folders above it are made.
    text
        Content of the file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, WritingError
        As `write_bytes`.
    """
    return write_bytes(path, text.encode(errors="replace"))


def write_json(path: Path, value: dict[str, Any]) -> Path:
    """Write an object as indented JSON, whole or not at all.

    Parameters
    ----------
    path
        File to write; folders above it are made.
    value
        Content of the file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        Where a number is NaN or infinite.
    InputError, WritingError
        As `write_bytes`.
    """
    return write_text(path, json_text(value))


def json_text(value: Any) -> str:
    """Convert a value to indented JSON.

    Parameters
    ----------
    value
        Anything that `json.dumps` takes.

    Returns
    -------
    str
        JSON with one space a level, characters beyond ASCII as they are, and a newline at the end.

    Raises
    ------
    ValueError
        Where a number is NaN or infinite.
    """
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_json(path: Path, wanted: str, schema: tuple[str, str] | None = None) -> dict[str, Any]:
    """Read the object that a JSON file holds.

    Parameters
    ----------
    path
        The file.
    wanted
        Kind of file that is expected, in words, as in ``an identification.json``.
    schema
        Package and file name of the JSON Schema that the content follows; where None it only has to be an object.

    Returns
    -------
    dict
        Content of the file.

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
    """Read the bytes of a regular file of limited size.

    A pipe would block the command, and a huge file would fill the memory.

    Parameters
    ----------
    path
        The file.
    wanted
        Kind of file that is expected, in words.

    Returns
    -------
    bytes
        At most `LARGEST_FILE` bytes.

    Raises
    ------
    InputError
        Where there is no such file, where it is a folder or a device, or has more than `LARGEST_FILE` bytes.
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
    """Return the reason of a reading error.

    Parameters
    ----------
    error
        Error of the system, or another one.

    Returns
    -------
    str
        Text without the file's path, which the message around it names already.
    """
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
