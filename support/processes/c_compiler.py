"""The C compiler of the ``ziglang`` package: options and a folder with sources in, compiled files in the folder out."""

from __future__ import annotations

import errno
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from haptid.support.errors import NumericalError
from haptid.support.files.cache import cache_folder, full_cache

MISSING = "the C compiler is missing: install it with python -m pip install ziglang"
_FULL = ("NoSpaceLeft", "No space left", "DiskQuota", "quota exceeded")
"""Names of a full disk in messages of the compiler and its linker, which not every message holds."""
_LEAST_FREE_BYTES = 1_000_000
"""Free space [bytes] below which a failed compilation is attributed to a full disk."""


def is_available() -> bool:
    """Say whether the package with the compiler is installed.

    Returns
    -------
    bool
        True where ``ziglang`` can be imported.
    """
    return importlib.util.find_spec("ziglang") is not None


def run_c_compiler(arguments: Sequence[str], folder: Path) -> None:
    """Run the C compiler.

    Parameters
    ----------
    arguments
        Options, and files by names relative to ``folder``: the compiler misreads a backslash in a path, say.
    folder
        Private folder within the cache that holds the files.

    Raises
    ------
    NumericalError
        Where the compiler is missing, refuses the source or is killed.
    WritingError
        Where the cache's disk is full.
    """
    if not is_available():
        raise NumericalError(MISSING)
    shared = cache_folder("zig")
    done = subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", *arguments],
        capture_output=True,
        text=True,
        errors="replace",
        env={"ZIG_GLOBAL_CACHE_DIR": str(shared), **os.environ},
        cwd=folder,
        check=False,
    )
    if done.returncode == 0:
        return
    said = done.stderr.strip()[-800:]
    if (
        any(word in said for word in _FULL)
        or min(shutil.disk_usage(path).free for path in (folder, shared)) < _LEAST_FREE_BYTES
    ):
        raise full_cache(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    ended = f"signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
    msg = f"the C compiler failed: {said or f'{ended}, without a word; is there enough memory?'}"
    raise NumericalError(msg)
