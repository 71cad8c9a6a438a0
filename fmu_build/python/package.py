"""The Python packaging in FMI 2.0: `Interface` in, files of the archive and GUID out.

1. pythonfmu builds an archive of the entry module, the slave, the fallback, the plan and the compiled kernels.
2. A guard, which answers all calls, takes the place of pythonfmu's loader.
3. ``modelDescription.xml`` is written by this package, not by pythonfmu.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import threading
from pathlib import Path

from pythonfmu.builder import FmuBuilder

from haptid.fmu_build.description.fmi2_xml import model_description
from haptid.fmu_build.description.identity import guid_of
from haptid.fmu_build.description.interface import Interface
from haptid.fmu_build.exchange.archive import unpack
from haptid.fmu_build.native.c_source import bare_libraries, flat_source, functions
from haptid.fmu_build.native.platforms import PLATFORMS, Platform
from haptid.fmu_build.python.fallback import fallback_source, module_text
from haptid.fmu_build.python.guard import guard_loaders, guard_source
from haptid.model.equations.fmu_names import SENSITIVITY_SWITCH

ENTRY = '''"""Entry of the slave."""

import {module}_slave as implementation

implementation.keep(globals())
Slave = implementation.Slave
'''
"""The module that pythonfmu's loader imports and whose classes it goes through: it holds one."""
_IMPORTING = threading.Lock()
"""pythonfmu changes the path of imports and the modules of this process: one thread at a time lets it."""


def plan_of(interface: Interface, module: str) -> dict[str, object]:
    """Return the content of ``plan.json``, which the slave reads.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    module
        Name of the entry module.

    Returns
    -------
    dict
        Start values by value reference, variables and names, ready for JSON.
    """
    return {
        "identifier": interface.identifier,
        "module": module,
        "functions": functions(interface.kernel),
        "start": interface.start,
        "switch": SENSITIVITY_SWITCH if interface.identification else "",
        "variables": [(v.name, v.reference, v.causality, v.variability, v.initial) for v in interface.variables],
    }


def kernel_files(interface: Interface, module: str, platforms: tuple[Platform, ...]) -> dict[str, bytes]:
    """Return the compiled kernels by their name below ``resources``.

    Parameters
    ----------
    interface
        Kernel of the FMU.
    module
        Name of the entry module. A process loads a library once for each path: the folder is named after the FMU, for
        hosts that unpack one FMU where another one was.
    platforms
        Platforms to compile for.

    Returns
    -------
    dict of str to bytes
        Content of the library by its name, as ``<module>_kernel/<platform>.so``.
    """
    built = bare_libraries(flat_source(interface.kernel), platforms)
    return {f"{module}_kernel/{p.python}{p.suffix}": built[p.python] for p in platforms}


def python_files(interface: Interface, *, platforms: tuple[Platform, ...], text: str) -> tuple[dict[str, bytes], str]:
    """Build the Python FMU.

    Parameters
    ----------
    interface
        Variables and kernel of the FMU.
    platforms
        Platforms to compile the kernel for.
    text
        Description of the model, one line.

    Returns
    -------
    files
        Content by name within the archive.
    guid
        Identity of the FMU.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.

    Notes
    -----
    The name of the module holds a digest of its content and platforms: Python keeps one module per name, and one
    process may load several FMUs.
    """
    slave, fallback = module_text("slave.py"), fallback_source(interface)
    plan = json.dumps(plan_of(interface, "?"))
    content = (ENTRY, slave, fallback, plan, flat_source(interface.kernel), guard_source(interface, ""))
    # The plan names the module, and the module's name holds the digest: the plan enters with "?" in its place.
    digest = _short(content)
    module = f"{interface.identifier}_{_short((digest, [p.python for p in platforms]))}"
    guid = guid_of(model_description(interface, guid="", python=True, text=text), digest)
    resources = {
        "plan.json": json.dumps(plan_of(interface, module)).encode(),
        f"{module}_slave.py": slave.encode(),
        f"{module}_fallback.py": fallback.encode(),
        **kernel_files(interface, module, platforms),
    }
    # Only this machine runs an identification FMU; any other falls back where it has no kernel, behind a guard as well.
    guarded = platforms if interface.identification else PLATFORMS
    files = guard_loaders(_build_archive(module, resources), interface, guid, guarded)
    files["modelDescription.xml"] = model_description(interface, guid=guid, python=True, text=text)
    return files, guid


def _short(content: object) -> str:
    """Return sixteen hex digits that change with ``content``."""
    return hashlib.sha256(repr(content).encode()).hexdigest()[:16]


def _build_archive(module: str, resources: dict[str, bytes]) -> dict[str, bytes]:
    """Let pythonfmu build the archive and return its files."""
    with _IMPORTING, tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "source"
        for path, content in resources.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(content)
        script = folder / f"{module}.py"
        script.write_text(ENTRY.format(module=module), encoding="utf-8")
        # pythonfmu imports the module to find its class; this process must not keep it, nor its folder.
        known, loaded = list(sys.path), set(sys.modules)
        try:
            others = sorted(path for path in folder.iterdir() if path != script)
            built = FmuBuilder.build_FMU(script, dest=Path(name) / "built.fmu", project_files=others)
        finally:
            sys.path[:] = known
            for fresh in {name for name in sys.modules if name.startswith(module)} - loaded:
                del sys.modules[fresh]
        return {k.replace("\\", "/"): v for k, v in unpack(built.read_bytes()).items() if "__pycache__" not in k}
