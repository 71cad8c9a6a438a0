"""The guard around pythonfmu's loader: files of an archive in, the same with a compiled guard before each loader out.

The guard checks the GUID and turns calls with logged errors into fmi2Error, which pythonfmu does not do.
"""

from __future__ import annotations

import json

from haptid.fmu_build.native.c_source import bare_library, text_of
from haptid.fmu_build.native.platforms import PLATFORMS

LOADERS = {"linux64": "pythonfmu-export.so", "win64": "pythonfmu-export.dll"}
"""Folder below ``binaries``, and the name under which the guard there finds pythonfmu's loader."""


def guard_source(guid: str) -> str:
    """Return the C source of the guard, which checks ``guid`` at instantiation."""
    parts = (text_of(name) for name in ("message.h", "location.c", "guard.c"))
    return "\n".join((text_of("fmi2.h"), f"#define FMU_GUID {json.dumps(guid)}", *parts))


def guard_loaders(files: dict[str, bytes], identifier: str, guid: str) -> dict[str, bytes]:
    """Put a guard in the place of each of pythonfmu's loaders.

    Parameters
    ----------
    files
        Content by name within the archive that pythonfmu built.
    identifier
        Model identifier, the name of the binaries.
    guid
        Identity that the guard checks at instantiation.

    Returns
    -------
    dict
        The same files with each loader renamed and the guard under the loader's former name.
    """
    result = dict(files)
    for p in PLATFORMS:
        folder = f"binaries/{p.fmi2[0]}"
        name = f"{folder}/{identifier}{p.suffix}"
        if p.fmi2[0] in LOADERS and name in result:
            result[f"{folder}/{LOADERS[p.fmi2[0]]}"] = result[name]
            flags = ("-lkernel32",) if p.suffix == ".dll" else ()
            result[name] = bare_library(guard_source(guid), p.triple, flags=flags).read_bytes()
    return result
