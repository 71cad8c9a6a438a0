"""C source on the flat buffer of `fmu_build.description.interface`: `Kernel` in, source and shared libraries out."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib import resources
from pathlib import Path

from haptid.fmu_build.description.interface import block_offsets
from haptid.fmu_build.native.mass_matrix import pivot_source
from haptid.fmu_build.native.platforms import Platform
from haptid.model.kernel.compiler import compile_shared
from haptid.model.kernel.generate import Kernel

SCALAR_FLAGS = ("-fno-slp-vectorize",)
"""Flags for one parameter set: packing the few scalars of a joint into vectors costs a tenth of a step."""
_FLAGS = ("-ffreestanding", "-nostdlib", *SCALAR_FLAGS)
_EXPORT = """#if defined(_WIN32)
#define HF_API __declspec(dllexport)
#else
#define HF_API __attribute__((visibility("default")))
#endif
"""


def text_of(name: str) -> str:
    """Return the text of a file in ``fmu_build/native/c``.

    Parameters
    ----------
    name
        Name of the file.

    Returns
    -------
    str
        Content of the file.
    """
    return resources.files("haptid.fmu_build.native").joinpath("c").joinpath(name).read_text(encoding="utf-8")


def layout(kernel: Kernel) -> str:
    """Return C macros with the index of each block of the buffer: ``HF_U``, ``HF_SLOPE`` and so on.

    Parameters
    ----------
    kernel
        Kernel with its sizes.

    Returns
    -------
    str
        One ``#define`` a block, on a line each.
    """
    at = block_offsets(kernel)
    return "\n".join((*(f"#define HF_{k.upper()} {n}" for k, n in at.items()), ""))


def kernel_source(kernel: Kernel) -> str:
    """Return the C source of a kernel as an FMU holds it: compiled once, stepped for long.

    Parameters
    ----------
    kernel
        Kernel, with or without sensitivities.

    Returns
    -------
    str
        Source of the kernel. Explicit equations are compiled into one function a step (``HK_TIGHT``): a quarter less
        time. The whole device, whose equations stand in a mass matrix, gains nothing by it.
    """
    tight = "" if kernel.equations.mass_matrix is not None else "#define HK_TIGHT\n"
    return f"#define HK_API static\n{tight}{kernel.source}"


def flat_source(kernel: Kernel) -> str:
    """Return the C source of a kernel with its functions on the flat buffer.

    Parameters
    ----------
    kernel
        Kernel, with or without sensitivities.

    Returns
    -------
    str
        One file. It exports the `functions` of the kernel; all other functions are static.
    """
    pivot = pivot_source(kernel.equations)
    return "\n".join((kernel_source(kernel), layout(kernel), _EXPORT, text_of("flat.c"), pivot))


def bare_library(source: str, triple: str, *, flags: tuple[str, ...] = ()) -> Path:
    """Compile one C source to a shared library that depends on no other library.

    Parameters
    ----------
    source
        C source.
    triple
        Compiler's name of the target platform.
    flags
        Further flags of the linker.

    Returns
    -------
    Path
        Library in the cache.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    files = {"all.c": source, "bare.c": text_of("bare.c")}
    return compile_shared(files, main=("all.c", "bare.c"), triple=triple, flags=(*_FLAGS, *flags))


def bare_libraries(source: str, platforms: Sequence[Platform]) -> dict[str, bytes]:
    """Compile one C source for several platforms, in parallel.

    Parameters
    ----------
    source
        C source.
    platforms
        Platforms to compile for.

    Returns
    -------
    dict
        Content of the shared library by ``Platform.python``.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        paths = pool.map(lambda p: bare_library(source, p.triple), platforms)
        return {p.python: path.read_bytes() for p, path in zip(platforms, paths, strict=True)}


def functions(kernel: Kernel) -> tuple[str, ...]:
    """Return the names of the exported functions on the flat buffer, those of the sensitivities where it has them.

    Parameters
    ----------
    kernel
        Kernel, with or without sensitivities.

    Returns
    -------
    tuple of str
        Names of C functions, those of the sensitivities last.
    """
    return ("hf_step", "hf_output", "hf_pivot", *(("hf_step_tangent", "hf_output_tangent") if kernel.columns else ()))
