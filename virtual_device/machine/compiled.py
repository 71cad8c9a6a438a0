"""The hand-written C sources of this package as loaded libraries, compiled once per source and kept in the cache."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from haptid.support.files.cache import cache_folder, is_sealed, seal, writing_to_cache
from haptid.support.processes.c_compiler import run_c_compiler

Array = NDArray[np.float64]
Doubles = ctypes.POINTER(ctypes.c_double)
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# Plain instructions and no contraction to fused operations: the same numbers on every processor of a kind.
FLAGS = ("-std=c99", "-O3", "-mcpu=baseline", "-ffp-contract=off", "-shared", "-fPIC", "-lm")


@functools.cache
def library(name: str, folder: Path = Path(__file__).parent) -> ctypes.CDLL:
    """Compile ``<name>.c`` of a folder with its headers (unless the cache has it) and load it.

    Parameters
    ----------
    name
        Name of the source without its suffix, as ``arm``.
    folder
        Folder of the source and its headers; this package's own by default.

    Returns
    -------
    ctypes.CDLL
        The loaded library, the same one at each call.

    Raises
    ------
    NumericalError
        Where the compiler is missing, refuses the source or is killed.
    WritingError
        Where the cache's disk is full.
    """
    sources = [folder / f"{name}.c", *sorted(folder.glob("*.h"))]
    content = b"".join(path.read_bytes() for path in sources)
    digest = hashlib.sha256(content + repr(FLAGS).encode() + sys.platform.encode()).hexdigest()[:16]
    target = cache_folder("virtual_device") / f"{name}_{digest}{SUFFIX}"
    if not is_sealed(target):
        _compile(sources, target)
        seal(target)
    return ctypes.CDLL(str(target))


def _compile(sources: Sequence[Path], target: Path) -> None:
    """Compile the first of ``sources``, which includes the others, into a temporary folder beside ``target``.

    The library moves to ``target`` at once, so that races are harmless.
    """
    with writing_to_cache(), tempfile.TemporaryDirectory(dir=target.parent) as name:
        folder = Path(name)
        for source in sources:
            shutil.copyfile(source, folder / source.name)
        made = folder / target.name
        run_c_compiler([*FLAGS, sources[0].name, "-o", made.name], folder)
        made.chmod(0o700)
        made.replace(target)


def doubles(array: Array) -> ctypes._Pointer[ctypes.c_double]:
    """Return the address of a contiguous float64 array for a C function.

    Parameters
    ----------
    array
        Contiguous array of any shape; it has to live as long as the address is used.

    Returns
    -------
    pointer to c_double
        Address of its first number.
    """
    return array.ctypes.data_as(Doubles)
