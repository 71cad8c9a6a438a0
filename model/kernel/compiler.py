"""Compilation by the C compiler inside the ``ziglang`` package: offline, for this machine or any other."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from haptid.support.errors import NumericalError
from haptid.support.files.cache import cache_folder, is_sealed, machine, seal

FLAGS = (
    "-std=gnu11",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-sanitize=undefined",
    "-fvisibility=hidden",
    "-g0",
    "-s",
    "-w",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A platform to compile for: the compiler's name of it, the FMI 2.0 folder and the suffix of a shared library."""

    triple: str
    fmi2_folder: str
    suffix: str


def available() -> bool:
    """Whether the compiler is installed."""
    return importlib.util.find_spec("ziglang") is not None


def _invoke(arguments: list[str]) -> None:
    if not available():
        msg = "the C compiler is missing: install it with python -m pip install ziglang"
        raise NumericalError(msg)
    environment = {"ZIG_GLOBAL_CACHE_DIR": str(cache_folder("zig")), **os.environ}
    done = subprocess.run(
        [sys.executable, "-m", "ziglang", "cc", *arguments],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    if done.returncode != 0:
        msg = f"the C compiler failed: {done.stderr.strip()[-800:]}"
        raise NumericalError(msg)


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
    """
    made_by = importlib.metadata.version("ziglang") if available() else ""
    made_for = triple or machine()
    parts = (sorted(sources.items()), main, made_for, flags, FLAGS, made_by)
    key = hashlib.sha256(repr(parts).encode()).hexdigest()[:24]
    suffix = ".dll" if triple and "windows" in triple else ".dylib" if triple and "macos" in triple else ".so"
    if triple is None and sys.platform in ("win32", "darwin"):
        suffix = {"win32": ".dll", "darwin": ".dylib"}[sys.platform]
    library = cache_folder("compiled") / f"{key}{suffix}"
    if is_sealed(library):
        return library
    target = ["-target", triple] if triple else ["-march=native"]
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        built = Path(folder) / f"built{suffix}"
        _invoke(
            [
                *target,
                *FLAGS,
                *flags,
                "-shared",
                "-fPIC",
                *(str(Path(folder) / name) for name in main),
                "-o",
                str(built),
            ]
        )
        built.chmod(0o700)
        built.replace(library)
    return seal(library)


def compile_kernel(source: str, *, lanes: int, substeps: int | None = None) -> Path:
    """Compile a kernel for this machine.

    Parameters
    ----------
    lanes
        Parameter sets side by side, beside the scalar form; 0 for that alone.
    substeps
        Most sub-steps of an inner step; the kernel's own number where None.
    """
    flags = () if substeps is None else (f"-DHK_MAX_SUBSTEPS={substeps}",)
    if lanes == 0:
        return compile_shared({"kernel.c": source}, main=("kernel.c",), flags=flags)
    vector = f'#define HK_LANES {lanes}\n#include "kernel.c"\n'
    return compile_shared({"kernel.c": source, "lanes.c": vector}, main=("kernel.c", "lanes.c"), flags=flags)
