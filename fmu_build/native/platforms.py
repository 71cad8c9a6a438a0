"""The platforms that an FMU carries binaries for, one `Platform` each with its names in compiler, FMI and Python."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Platform:
    """Name a platform as the compiler, FMI and Python do.

    Parameters
    ----------
    triple
        Target triple of the compiler.
    fmi2
        Folders below ``binaries`` where FMI 2.0 hosts look; two names for one place where hosts differ.
    fmi3
        The folder in FMI 3.0, its platform tuple.
    python
        ``sys.platform`` and machine as Python names them.
    suffix
        Suffix of a shared library, with its dot.
    """

    triple: str
    fmi2: tuple[str, ...]
    fmi3: str
    python: str
    suffix: str


PLATFORMS = (
    Platform(
        triple="x86_64-linux-gnu.2.17", fmi2=("linux64",), fmi3="x86_64-linux", python="linux-x86_64", suffix=".so"
    ),
    Platform(
        triple="aarch64-linux-gnu.2.17",
        fmi2=("aarch64-linux",),
        fmi3="aarch64-linux",
        python="linux-aarch64",
        suffix=".so",
    ),
    Platform(triple="x86_64-windows-gnu", fmi2=("win64",), fmi3="x86_64-windows", python="win32-x86_64", suffix=".dll"),
    Platform(
        triple="x86_64-macos.11.0", fmi2=("darwin64",), fmi3="x86_64-darwin", python="darwin-x86_64", suffix=".dylib"
    ),
    Platform(
        triple="aarch64-macos.11.0",
        fmi2=("aarch64-darwin",),
        fmi3="aarch64-darwin",
        python="darwin-aarch64",
        suffix=".dylib",
    ),
)
_MACHINES = {"amd64": "x86_64", "x64": "x86_64", "arm64": "aarch64"}


def this_platform() -> tuple[Platform, ...]:
    """Find the platform of this machine.

    Returns
    -------
    tuple of Platform
        A tuple of one; empty where `PLATFORMS` lacks it.
    """
    machine = _MACHINES.get(platform.machine().lower(), platform.machine().lower())
    return tuple(p for p in PLATFORMS if p.python == f"{sys.platform}-{machine}")
