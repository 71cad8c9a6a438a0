"""The native packaging: one C source, the kernel with FMI 2.0 around it, compiled for every platform, no libraries."""

from __future__ import annotations

from haptid.fmu_build.description.fmi2_xml import model_description
from haptid.fmu_build.description.identity import guid_of
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.native.c_source import bare_libraries, layout, text_of
from haptid.fmu_build.native.c_tables import input_jacobian, tables
from haptid.fmu_build.native.mach_o import universal
from haptid.fmu_build.native.platforms import Platform

PARTS = ("fmi2_instance.c", "fmi2_state.c", "fmi2_co_simulation.c", "fmi2_model_exchange.c")


def native_source(
    interface: Interface, guid: str, *, headers: tuple[str, ...] = ("fmi2.h",), parts: tuple[str, ...] = PARTS
) -> str:
    """Return the whole FMU as one C file."""
    kernel = interface.kernel
    return "\n".join(
        (
            "#define HK_API static",
            "#define HF_API static",
            kernel.source,
            layout(kernel),
            text_of("flat.c"),
            input_jacobian(kernel.equations) if kernel.columns else "",
            *map(text_of, headers),
            tables(interface, guid),
            text_of("message.h"),
            *map(text_of, parts),
        )
    )


def native_files(interface: Interface, *, platforms: tuple[Platform, ...], text: str) -> tuple[dict[str, bytes], str]:
    """Return the files of the native FMU, and its GUID."""
    guid = guid_of(model_description(interface, guid="", python=False, text=text), native_source(interface, ""))
    source = native_source(interface, guid)
    files = {
        "modelDescription.xml": model_description(interface, guid=guid, python=False, text=text),
        "sources/all.c": source.encode(),
    }
    built = bare_libraries(source, platforms)
    for p in platforms:
        for folder in p.fmi2:
            files[f"binaries/{folder}/{interface.identifier}{p.suffix}"] = built[p.python]
    apple = [built[name] for name in ("darwin-x86_64", "darwin-aarch64") if name in built]
    if len(apple) == 2:
        files[f"binaries/darwin64/{interface.identifier}.dylib"] = universal(*apple)
    return files, guid
