"""The native packaging in FMI 3.0: `Interface` in, files of the archive and instantiation token out.

The FMI 2.0 functions stay as they are, static, and the FMI 3.0 functions call them: names, types and modes differ.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

from haptid.fmu_build.description.fmi3_xml import build_description, model_description3
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_library
from haptid.fmu_build.native.fmi2 import PARTS, SOURCE, identified_files, native_source
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
"""Linker flags by which a binary finds functions for memory; on Linux the host process has them in its C library."""


def native_source3(interface: Interface, token: str) -> str:
    """Return the whole FMU in FMI 3.0 as one C file (see `native_source`).

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    token
        Instantiation token.

    Returns
    -------
    str
        C source.
    """
    return native_source(interface, token, headers=("fmi2.h", "fmi3.h"), parts=(*PARTS, *PARTS3))


def native_files3(interface: Interface, *, platforms: tuple[Platform, ...], text: str) -> tuple[dict[str, bytes], str]:
    """Build the native FMU in FMI 3.0.

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
        Content by name within the archive: descriptions, source and binaries.
    token
        Instantiation token, the identity of the FMU.
    """
    files, token = identified_files(
        lambda token: model_description3(interface, token=token, text=text),
        lambda token: native_source3(interface, token),
    )
    files["sources/buildDescription.xml"] = build_description(interface.identifier)
    source = files[SOURCE].decode()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        built = pool.map(lambda p: bare_library(source, p.triple, flags=_FLAGS[p.suffix]), platforms)
        for p, path in zip(platforms, built, strict=True):
            files[f"binaries/{p.fmi3}/{interface.identifier}{p.suffix}"] = path.read_bytes()
    return files, token


def rename_picture(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files with ``model.png`` moved to ``terminalsAndIcons/icon.png``, its place in FMI 3.0.

    Parameters
    ----------
    files
        Content by name within the archive.

    Returns
    -------
    dict of str to bytes
        The same content by name in FMI 3.0.
    """
    return {("terminalsAndIcons/icon.png" if name == "model.png" else name): data for name, data in files.items()}
