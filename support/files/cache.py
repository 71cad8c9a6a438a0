"""The cache on disk: private folders of the user, and entries whose digest is verified at each use.

Entries hold compiled code that is loaded, so that nobody else may have written them.
"""

from __future__ import annotations

import atexit
import errno
import hashlib
import os
import platform
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from haptid.support.errors import HaptidError, InputError, one_line, shorten
from haptid.support.files.files import WritingError, write_text

VARIABLE = "HAPTID_CACHE"
_PRIVATE = 0o700
_ESCAPE = re.compile("%[0-9A-Fa-f]{2}")
_OTHERS_MAY_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cache_folder(name: str) -> Path:
    """Return (and make) a cache folder below $HAPTID_CACHE, default ``.cache/haptid`` in the home folder.

    Where the folder cannot be written, belongs to another user, or cannot hold programs that run, a private temporary
    folder replaces it until the program ends, and one line on stderr says so.

    Parameters
    ----------
    name
        Name of the folder within the cache.

    Returns
    -------
    Path
        A folder that can be written.

    Raises
    ------
    InputError
        Where the temporary folder cannot hold programs that run, either.
    """
    folder = _base() / name
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=_PRIVATE)
        if not _is_own(folder):
            return _temporary(f"{folder} belongs to somebody else", name)
        if unfit := _unfit(folder):
            return _temporary(unfit, name)
        folder.chmod(_PRIVATE)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        return _temporary(f"{folder}: {error.strerror}", name)


def give_matplotlib_a_folder() -> None:
    """Let matplotlib keep its files in the cache where the home folder cannot be written.

    It must be called before matplotlib is imported, which would warn in two lines at every start otherwise.
    """
    if "MPLCONFIGDIR" in os.environ or os.name != "posix":
        return
    try:
        for variable, default in (("XDG_CONFIG_HOME", ".config"), ("XDG_CACHE_HOME", ".cache")):
            folder = Path(os.environ.get(variable) or Path.home() / default) / "matplotlib"
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                pass
    except (OSError, RuntimeError):
        os.environ["MPLCONFIGDIR"] = str(cache_folder("matplotlib"))


@contextmanager
def writing_to_cache() -> Iterator[None]:
    """Turn a full disk within the block into an error that names the cache: its files' names mean nothing to users.

    Raises
    ------
    WritingError
        Where the disk or the quota of the cache is full.
    """
    try:
        yield
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise full_cache(error) from None


def full_cache(error: OSError) -> HaptidError:
    """Put the remedy into the error of a cache whose disk is full.

    Parameters
    ----------
    error
        Error of the system.

    Returns
    -------
    WritingError
        It names the folder of the cache; the caller raises it.
    """
    todo = f"free some space there, or set {VARIABLE} to a folder elsewhere, then repeat"
    return WritingError(f"{_base()}: the cache could not be written ({error.strerror}); {todo}")


def seal(entry: Path) -> Path:
    """Record the digest of an entry that has just been written whole.

    Parameters
    ----------
    entry
        A file or a folder in the cache.

    Returns
    -------
    Path
        ``entry``.
    """
    write_text(_record(entry), _digest(entry))
    return entry


def is_sealed(entry: Path) -> bool:
    """Return whether an entry is the user's own, is no link, and has the content that it had when it was sealed.

    Parameters
    ----------
    entry
        A file or a folder in the cache.

    Returns
    -------
    bool
        False too where it does not exist, was not sealed, or others may write it.
    """
    record = _record(entry)
    try:
        own = all(_is_own(path) and path.lstat().st_mode & _OTHERS_MAY_WRITE == 0 for path in (entry, record))
        linked = entry.is_symlink() or record.is_symlink()
        return own and not linked and record.read_text(encoding="utf-8") == _digest(entry)
    except (OSError, UnicodeDecodeError):
        return False


@cache
def machine() -> str:
    """Compute a digest of what compiled code depends on beside its source: system, processor and its instructions.

    Returns
    -------
    str
        Sixteen hex digits.
    """
    parts = [sys.platform, platform.machine(), platform.processor(), platform.libc_ver()[0]]
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    wanted = ("model name", "flags", "Features", "CPU part", "CPU implementer")
    parts += sorted({line for line in lines if line.startswith(wanted)})
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _base() -> Path:
    given = os.environ.get(VARIABLE, "").strip()
    if given:
        return Path(given).absolute()
    try:
        return Path.home() / ".cache" / "haptid"
    except RuntimeError:  # no HOME, and no entry in the list of users
        return _temporary("there is no home folder", "")


def _temporary(why: str, name: str) -> Path:
    """Return a private folder for this program and the processes that it starts, removed when the program ends."""
    folder = Path(tempfile.mkdtemp(prefix="haptid-cache-"))
    told = f"note: no cache ({shorten(one_line(why), 150)}): {folder} serves this once"
    print(f"{told}; set {VARIABLE} to a folder of yours", file=sys.stderr)
    os.environ[VARIABLE] = str(folder)  # child processes, and later calls, find it there
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / name).mkdir(mode=_PRIVATE, exist_ok=True)
    if unfit := _unfit(folder):
        todo = f"set {VARIABLE}, or TMPDIR, to such a folder"
        raise InputError(VARIABLE, expected="a folder that can hold programs that run", got=unfit, todo=todo)
    return folder / name


def _unfit(folder: Path) -> str:
    """Return why files unpacked or compiled below ``folder`` could not be loaded; empty where they can."""
    try:
        str(folder).encode()
    except UnicodeEncodeError:  # Python code inside an FMU is found by a path in UTF-8
        return f"{folder} is no path in UTF-8"
    if _ESCAPE.search(str(folder)) or not str(folder).isprintable():  # pythonfmu's loader and the compiler decode it
        return f"{folder} has %41, %20 or the like in its name, or what cannot be printed"
    if hasattr(os, "statvfs") and os.statvfs(folder).f_flag & getattr(os, "ST_NOEXEC", 0):
        return f"{folder} is on a file system that is mounted noexec"
    return ""


def _is_own(path: Path) -> bool:
    return not hasattr(os, "getuid") or path.lstat().st_uid == os.getuid()


def _record(entry: Path) -> Path:
    return entry.with_name(f"{entry.name}.sha256")


def _digest(entry: Path) -> str:
    if not entry.is_dir():
        return hashlib.sha256(entry.read_bytes()).hexdigest()
    found = hashlib.sha256()
    for path in sorted(entry.rglob("*")):  # bytecode counts too: the interpreter would run it in place of its source
        content = ""
        if path.is_symlink():
            content = "link"
        elif not path.is_dir():
            content = _digest(path)
        found.update(f"{path.relative_to(entry).as_posix()}\n{content}\n".encode())
    return found.hexdigest()
