"""The guard before pythonfmu's loader: files of an archive in, the same with a compiled guard before each loader out.

pythonfmu's loader knows no modes, leaks and loses saved states, and ends the host where a call or a path is not as it
expects. The guard is the native FMU's own answer to FMI, around the buffer that the slave inside holds.
"""

from __future__ import annotations

from collections.abc import Sequence

from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_library, layout, text_of
from haptid.fmu_build.native.c_tables import tables
from haptid.fmu_build.native.fmi2 import CORE, MODES
from haptid.fmu_build.native.platforms import PLATFORMS, Platform

LOADERS = {"linux64": "pythonfmu-export.so", "win64": "pythonfmu-export.dll"}
"""Folder below ``binaries``, and the name under which the guard there finds pythonfmu's loader."""


def guard_source(interface: Interface, guid: str) -> str:
    """Return the C source of the guard.

    Parameters
    ----------
    interface
        Variables of the FMU.
    guid
        Identity that instantiation checks.

    Returns
    -------
    str
        One C file.
    """
    e = interface.equations
    sizes = "\n".join((f"#define HK_NX {len(e.states)}", f"#define HK_NU {len(e.inputs)}"))
    files = ("message.h", "location.c", MODES, "python_kernel.c", *CORE)
    head = (text_of("fmi2.h"), sizes, layout(interface.kernel), tables(interface, guid, exchange=False))
    return "\n".join((*head, *map(text_of, files)))


def guard_loaders(
    files: dict[str, bytes], interface: Interface, guid: str, platforms: Sequence[Platform]
) -> dict[str, bytes]:
    """Put a guard in the place of each of pythonfmu's loaders; those for other platforms are left out.

    Parameters
    ----------
    files
        Content by name within the archive that pythonfmu built.
    interface
        Variables and model identifier, the name of the binaries.
    guid
        Identity that the guard checks at instantiation.
    platforms
        Platforms that the FMU may be run on.

    Returns
    -------
    dict
        The same files with each loader renamed and the guard under the loader's former name.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    result = dict(files)
    for p in PLATFORMS:
        folder = f"binaries/{p.fmi2[0]}"
        name = f"{folder}/{interface.identifier}{p.suffix}"
        if p.fmi2[0] not in LOADERS or name not in result:
            continue
        if p in platforms:
            result[f"{folder}/{LOADERS[p.fmi2[0]]}"] = result[name]
            flags = ("-lkernel32",) if p.suffix == ".dll" else ()
            result[name] = bare_library(guard_source(interface, guid), p.triple, flags=flags).read_bytes()
        else:
            del result[name]
    return result
