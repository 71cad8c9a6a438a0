"""The native packaging in FMI 3.0: the FMI 2.0 layer as it is, private, below the names, types and modes of 3.0."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

from haptid.fmu_build.description.fmi3_xml import build_description, model_description3
from haptid.fmu_build.description.identity import guid_of
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_library
from haptid.fmu_build.native.fmi2 import PARTS, native_source
from haptid.fmu_build.native.platforms import Platform

PARTS3 = (
    "fmi3_memory.c",
    "fmi3_instance.c",
    "fmi3_values.c",
    "fmi3_clocks.c",
    "fmi3_state.c",
    "fmi3_model_exchange.c",
    "fmi3_co_simulation.c",
)
_FLAGS = {".so": (), ".dll": ("-lkernel32",), ".dylib": ("-lSystem",)}
"""Where a platform's binaries find memory: on Linux in whatever C library the process has."""


def native_source3(interface: Interface, token: str) -> str:
    """Return the whole FMU as one C file."""
    return native_source(interface, token, headers=("fmi2.h", "fmi3.h"), parts=(*PARTS, *PARTS3))


def native_files3(interface: Interface, *, platforms: tuple[Platform, ...], text: str) -> tuple[dict[str, bytes], str]:
    """Return the files of the native FMI 3.0 FMU, and its instantiation token."""
    token = guid_of(model_description3(interface, token="", text=text), native_source3(interface, ""))
    source = native_source3(interface, token)
    files = {
        "modelDescription.xml": model_description3(interface, token=token, text=text),
        "sources/all.c": source.encode(),
        "sources/buildDescription.xml": build_description(interface.identifier),
    }
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        built = pool.map(lambda p: bare_library(source, p.triple, flags=_FLAGS[p.suffix]), platforms)
        for p, path in zip(platforms, built, strict=True):
            files[f"binaries/{p.fmi3}/{interface.identifier}{p.suffix}"] = path.read_bytes()
    return files, token


def rename_picture(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files with the picture where FMI 3.0 looks for it."""
    return {("terminalsAndIcons/icon.png" if name == "model.png" else name): data for name, data in files.items()}
