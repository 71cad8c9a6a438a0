"""The native packaging in FMI 2.0: `Interface` in, files of the archive and GUID out.

One C source, the kernel and the FMI functions around it, is compiled for every platform and needs no library.
"""

from __future__ import annotations

from collections.abc import Callable

from haptid.fmu_build.description.fmi2_xml import model_description
from haptid.fmu_build.description.identity import guid_of
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_libraries, kernel_source, layout, text_of
from haptid.fmu_build.native.c_tables import input_jacobian, tables
from haptid.fmu_build.native.mach_o import universal
from haptid.fmu_build.native.mass_matrix import pivot_source
from haptid.fmu_build.native.platforms import Platform

MODES, KERNEL = "fmi2_modes.c", "native_kernel.c"
CORE = (
    "fmi2_consistency.c",
    "fmi2_instance.c",
    "fmi2_values.c",
    "fmi2_state.c",
    "fmi2_derivative.c",
    "fmi2_co_simulation.c",
)
"""C files that both packagings answer by; before them stand `MODES` and the file of the kernel."""
PARTS = (MODES, KERNEL, *CORE, "fmi2_model_exchange.c")
_HOW_TO_COMPILE = """/* {identifier}: the whole FMU in one C99 file. It needs no other, and -lm for the square root:
 *     cc -std=c99 -O2 -shared -fPIC all.c -o {identifier}.so -lm
 * With -DFMI2_FUNCTION_PREFIX={identifier}_ (FMI3_FUNCTION_PREFIX in FMI 3.0) its functions have names of their own,
 * by which several FMUs can be linked into one program. */"""
SOURCE = "sources/all.c"
"""Name of the C source within the archive."""


def native_source(
    interface: Interface, guid: str, *, headers: tuple[str, ...] = ("fmi2.h",), parts: tuple[str, ...] = PARTS
) -> str:
    """Return the whole FMU as one C file.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    guid
        Identity that instantiation checks.
    headers
        C headers of the FMI versions, in order.
    parts
        C files of the FMI functions, in order: each uses the static functions of those before.

    Returns
    -------
    str
        C99 source that includes no file of this package.
    """
    kernel = interface.kernel
    return "\n".join(
        (
            _HOW_TO_COMPILE.format(identifier=interface.identifier),
            "#define HF_API static",
            kernel_source(kernel),
            layout(kernel),
            text_of("flat.c"),
            pivot_source(kernel.equations),
            input_jacobian(kernel.equations) if kernel.columns else "",
            *map(text_of, headers),
            tables(interface, guid),
            text_of("message.h"),
            *map(text_of, parts),
        )
    )


def identified_files(describe: Callable[[str], bytes], write: Callable[[str], str]) -> tuple[dict[str, bytes], str]:
    """Return the files of an FMU that hold its identity, and the identity.

    Parameters
    ----------
    describe, write
        Model description and C source from the identity.

    Returns
    -------
    files
        Content by name within the archive.
    identity
        GUID of their content.
    """
    # The identity stands in the files that it identifies, so it is computed of the same files without it.
    identity = guid_of(describe(""), write(""))
    return {"modelDescription.xml": describe(identity), SOURCE: write(identity).encode()}, identity


def native_files(interface: Interface, *, platforms: tuple[Platform, ...], text: str) -> tuple[dict[str, bytes], str]:
    """Build the native FMU in FMI 2.0.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    platforms
        Platforms to compile for.
    text
        Description of the model, one line.

    Returns
    -------
    files
        Content by name within the archive: description, source and binaries.
    guid
        Identity of the FMU.
    """
    files, guid = identified_files(
        lambda guid: model_description(interface, guid=guid, python=False, text=text),
        lambda guid: native_source(interface, guid),
    )
    built = bare_libraries(files[SOURCE].decode(), platforms)
    for p in platforms:
        for folder in p.fmi2:
            files[f"binaries/{folder}/{interface.identifier}{p.suffix}"] = built[p.python]
    # FMI 2.0 has one folder for Apple, darwin64: a universal binary there serves hosts on both processors.
    apple = [built[name] for name in ("darwin-x86_64", "darwin-aarch64") if name in built]
    if len(apple) == 2:
        files[f"binaries/darwin64/{interface.identifier}.dylib"] = universal(*apple)
    return files, guid
