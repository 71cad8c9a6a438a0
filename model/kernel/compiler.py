"""Compilation by the C compiler inside the ``ziglang`` package: offline, for this machine or any other.

C source comes in, the path of a shared library in the cache goes out.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from haptid.support.files.cache import cache_folder, is_sealed, machine, seal, writing_to_cache
from haptid.support.processes.c_compiler import is_available, run_c_compiler

FLAGS = (
    "-std=gnu11",
    "-O3",
    "-ffp-contract=off",  # no fused multiply-add: lanes, scalars and platforms agree bit for bit
    "-fno-math-errno",
    "-fno-sanitize=undefined",
    "-fvisibility=hidden",
    "-g0",
    "-s",
    "-w",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A platform to compile for.

    Parameters
    ----------
    triple
        The compiler's name of the platform.
    fmi2_folder
        Folder of the platform's binaries in an FMU after FMI 2.0.
    suffix
        Suffix of a shared library, with its dot.
    """

    triple: str
    fmi2_folder: str
    suffix: str


def compile_shared(
    sources: dict[str, str], *, main: tuple[str, ...], triple: str | None = None, flags: tuple[str, ...] = ()
) -> Path:
    """Compile C sources to a shared library and return its path in the cache.

    Parameters
    ----------
    sources
        File name to text; headers among them.
    main
        The names to compile.
    triple
        Compiler's name of the target platform; this machine, with all its instructions, where None.
    flags
        Further flags of the compiler, after `FLAGS`.

    Returns
    -------
    Path
        Shared library, keyed by sources, platform, flags and version of the compiler.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    made_by = importlib.metadata.version("ziglang") if is_available() else ""
    made_for = triple or machine()
    parts = (sorted(sources.items()), main, made_for, flags, FLAGS, made_by)
    key = hashlib.sha256(repr(parts).encode()).hexdigest()[:24]
    suffix = _suffix(triple)
    library = cache_folder("compiled") / f"{key}{suffix}"
    if is_sealed(library):
        return library
    target = ["-target", triple] if triple else ["-march=native"]
    if triple is None and sys.platform == "linux":
        # The process that loads the library has a libc; the compiler would first make the files of one to link with,
        # which takes seconds where its cache is new.
        target.append("-nostdlib")
    # built in a folder beside the library and then renamed: no other process sees a library that is half written
    with writing_to_cache(), tempfile.TemporaryDirectory(dir=library.parent) as name:
        folder = Path(name)
        for source, text in sources.items():
            (folder / source).write_text(text, encoding="utf-8")
        built = folder / f"built{suffix}"
        run_c_compiler([*target, *FLAGS, *flags, "-shared", "-fPIC", *main, "-o", built.name], folder)
        built.chmod(0o700)
        built.replace(library)
    return seal(library)


def compile_kernel(source: str, *, lanes: int, substeps: int | None = None) -> Path:
    """Compile a kernel for this machine.

    Parameters
    ----------
    source
        C source of a kernel, as from `generate`.
    lanes
        Number of parameter sets side by side in the vectorised form, which is added to the scalar form; 0 for the
        scalar form alone.
    substeps
        Largest number of sub-steps of an inner step; the kernel's default where None.

    Returns
    -------
    Path
        Shared library.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    flags = () if substeps is None else (f"-DHK_MAX_SUBSTEPS={substeps}",)
    if lanes == 0:
        return compile_shared({"kernel.c": source}, main=("kernel.c",), flags=flags)
    vector = f'#define HK_LANES {lanes}\n#include "kernel.c"\n'
    return compile_shared({"kernel.c": source, "lanes.c": vector}, main=("kernel.c", "lanes.c"), flags=flags)


def _suffix(triple: str | None) -> str:
    """Return what ends the name of a library for a target, or for this machine where None."""
    target = sys.platform if triple is None else triple
    if target == "win32" or "windows" in target:
        return ".dll"
    if target == "darwin" or "macos" in target:
        return ".dylib"
    return ".so"
