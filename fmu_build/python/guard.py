"""The guard around pythonfmu's loader, compiled for the platforms that pythonfmu has a loader for."""

from __future__ import annotations

import json

from haptid.fmu_build.native.c_source import bare_library, text_of
from haptid.fmu_build.native.platforms import PLATFORMS

LOADERS = {"linux64": "pythonfmu-export.so", "win64": "pythonfmu-export.dll"}
"""Folder below ``binaries`` to the name that the loader gets there."""


def guard_source(guid: str) -> str:
    """Return the guard's C source."""
    parts = (text_of(name) for name in ("message.h", "location.c", "guard.c"))
    return "\n".join((text_of("fmi2.h"), f"#define FMU_GUID {json.dumps(guid)}", *parts))


def guard_loaders(files: dict[str, bytes], identifier: str, guid: str) -> dict[str, bytes]:
    """Return the archive's files with each loader set aside under its own name and the guard in its place."""
    result = dict(files)
    for p in PLATFORMS:
        folder = f"binaries/{p.fmi2[0]}"
        name = f"{folder}/{identifier}{p.suffix}"
        if p.fmi2[0] in LOADERS and name in result:
            result[f"{folder}/{LOADERS[p.fmi2[0]]}"] = result[name]
            flags = ("-lkernel32",) if p.suffix == ".dll" else ()
            result[name] = bare_library(guard_source(guid), p.triple, flags=flags).read_bytes()
    return result
