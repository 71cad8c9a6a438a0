"""The hand-written C sources of this package as loaded libraries, compiled once per source and kept in the cache."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from haptid.support.errors import NumericalError
from haptid.support.files.cache import cache_folder, is_sealed, seal

Array = NDArray[np.float64]
Doubles = ctypes.POINTER(ctypes.c_double)
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# Plain instructions and no contraction to fused operations: the same numbers on every processor of a kind.
FLAGS = ("-std=c99", "-O3", "-mcpu=baseline", "-ffp-contract=off", "-shared", "-fPIC", "-lm")


@functools.cache
def library(name: str) -> ctypes.CDLL:
    """Compile ``<name>.c`` of this package (unless the cache has it) and load it."""
    source = Path(__file__).with_name(f"{name}.c")
    digest = hashlib.sha256(source.read_bytes() + repr(FLAGS).encode() + sys.platform.encode()).hexdigest()[:16]
    target = cache_folder("virtual_device") / f"{name}_{digest}{SUFFIX}"
    if not is_sealed(target):
        _compile(source, target)
        seal(target)
    return ctypes.CDLL(str(target))


def _compile(source: Path, target: Path) -> None:
    """Compile into a temporary folder beside ``target`` and move it there at once, so that races are harmless."""
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        made = Path(folder) / target.name
        command = [sys.executable, "-m", "ziglang", "cc", *FLAGS, str(source), "-o", str(made)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            msg = f"{source.name} did not compile: {done.stderr.strip()}"
            raise NumericalError(msg)
        made.chmod(0o700)
        os.replace(made, target)  # noqa: PTH105 - the atomic form


def doubles(array: Array) -> ctypes._Pointer[ctypes.c_double]:
    """Return the address of a contiguous float64 array for a C function."""
    return array.ctypes.data_as(Doubles)
