"""The C compiler inside the ``ziglang`` package, and what is said where it is missing or fails."""

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
"""How the compiler and its linker name a full disk, where they name it at all."""
_SPARE = 1_000_000
"""Bytes that a compilation needs at least: with less the disk is taken to be full."""


def is_available() -> bool:
    """Whether the compiler is installed."""
    return importlib.util.find_spec("ziglang") is not None


def run_c_compiler(arguments: Sequence[str], folder: Path) -> None:
    """Run the compiler in ``folder``, a private one within the cache.

    Parameters
    ----------
    arguments
        Options, and files by names relative to ``folder``: a backslash in a path, say, is not taken for what it is.
    folder
        Where the files lie.

    Raises
    ------
    NumericalError
        Where the compiler is missing or refuses the source.
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
    if any(word in said for word in _FULL) or min(shutil.disk_usage(path).free for path in (folder, shared)) < _SPARE:
        raise full_cache(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    ended = f"signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
    msg = f"the C compiler failed: {said or f'{ended}, without a word; is there enough memory?'}"
    raise NumericalError(msg)
