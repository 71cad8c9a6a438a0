"""Content of the lock file: name of a part in, its distributions and the size of their installation out.

The requirements in ``locked/*.txt`` beside this module are exported from uv.lock with the hash of every file. Standard
library only, because it runs before anything is installed.
"""

from __future__ import annotations

import json
import platform
import re
import sys
import tomllib
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from haptid.support.installing.environment import ROOT, applies

FOLDER = ROOT / "support" / "installing" / "locked"
CORE, DEV = "core", "dev"
SIZES = FOLDER / "sizes.json"
"""File of measured sizes on disk [bytes] by name: uv.lock holds only the size of a download."""
_SIZE_OVER_DOWNLOAD = 4
"""Size on disk over size of the download that is assumed where no size on disk was measured [1]."""

_PIN = re.compile(r"^(?P<name>[\w.-]+)==(?P<version>[^\s;]+)\s*(;\s*(?P<marker>[^\\]*?))?\s*\\?$")
_SYSTEMS = {"linux": "manylinux", "darwin": "macosx", "win32": "win"}
_MACHINES = {
    "aarch64": ("aarch64",),
    "amd64": ("x86_64", "amd64", "universal2"),
    "arm64": ("arm64", "universal2"),
    "x86_64": ("x86_64", "amd64", "universal2"),
}


@dataclass(frozen=True, slots=True)
class Pin:
    """One distribution of the lock file, pinned to a version.

    Parameters
    ----------
    name, version
        Name of the distribution, and the one version that is allowed.
    """

    name: str
    version: str

    @property
    def met(self) -> bool:
        """Whether the interpreter in use has exactly this version."""
        try:
            return metadata.version(self.name) == self.version
        except metadata.PackageNotFoundError:
            return False


@dataclass(frozen=True, slots=True)
class Amount:
    """Size of an installation.

    Parameters
    ----------
    count
        Number of distributions.
    size, on_disk
        Size of their downloads and of their installed files [bytes].
    """

    count: int
    size: int
    on_disk: int

    def __str__(self) -> str:
        """Write the sizes in words, for a user who decides whether to install now."""
        noun = "distribution" if self.count == 1 else "distributions"
        fetched, kept = (max(round(size / 1e6), 1) for size in (self.size, self.on_disk))
        return f"{self.count} {noun}, {fetched} MB to download, about {kept} MB on disk"


def locked_file(part: str) -> Path:
    """Locate a part's requirements with hashes.

    Parameters
    ----------
    part
        ``core``, ``dev`` or an extra; every part includes the core.

    Returns
    -------
    Path
        Path of the file, whether it exists or not.
    """
    return FOLDER / f"{part}.txt"


def pins(part: str) -> tuple[Pin, ...]:
    """Return the distributions of a part that apply to this machine.

    Parameters
    ----------
    part
        ``core``, ``dev`` or an extra; every part includes the core.

    Returns
    -------
    tuple of Pin
        In the order of the file.
    """
    matches = map(_PIN.match, locked_file(part).read_text(encoding="utf-8").splitlines())
    return tuple(Pin(m["name"], m["version"]) for m in matches if m and applies(m["marker"]))


def amount(part: str, *, again: bool = False) -> Amount:
    """Estimate the size of an installation by the sizes in uv.lock.

    Parameters
    ----------
    part
        ``core``, ``dev`` or an extra.
    again
        Whether distributions that are installed already count too.

    Returns
    -------
    Amount
        Number of distributions, and their sizes as they come and on disk [bytes].
    """
    packages = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))["package"]
    known = {(p["name"], p.get("version")): p for p in packages}
    lacking = [pin for pin in pins(part) if again or not pin.met]
    fetched = {pin.name: _size(known[pin.name, pin.version]) for pin in lacking}
    measured = json.loads(SIZES.read_text(encoding="utf-8")) if SIZES.is_file() else {}
    on_disk = sum(measured.get(name, _SIZE_OVER_DOWNLOAD * size) for name, size in fetched.items())
    return Amount(len(lacking), sum(fetched.values()), on_disk)


def _size(package: dict[str, Any]) -> int:
    """Return the size [bytes] of the file that an installer takes: a wheel for this machine, else the source."""
    wheels = [w for w in package.get("wheels", []) if _fits(w["url"].rpartition("/")[2])]
    files = wheels or [package["sdist"]] if "sdist" in package else wheels
    return max((int(f.get("size", 0)) for f in files), default=0)


def _fits(wheel: str) -> bool:
    """Whether a wheel's name says that it is for this Python, system and machine."""
    python, abi, system = wheel.removesuffix(".whl").split("-")[-3:]
    this = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    if not (this in python.split(".") or "py3" in python or "abi3" in abi.split(".")):
        return False
    if abi.endswith("t") and abi.startswith("cp"):
        return False  # free-threaded
    machines = _MACHINES.get(platform.machine().lower(), (platform.machine(),))
    return system == "any" or (_SYSTEMS.get(sys.platform, "") in system and any(m in system for m in machines))
