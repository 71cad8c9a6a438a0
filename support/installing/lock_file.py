"""What the lock file would install here: ``support/locked/*.txt``, exported from uv.lock with the hash of every file.

Standard library only: this runs before anything is installed.
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
"""Bytes on disk by name, measured where they were installed: uv.lock holds only what is downloaded."""
_UNPACKED = 4
"""Bytes on disk for one that is downloaded, where it was not measured."""

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
    """One distribution of the lock file."""

    name: str
    version: str

    @property
    def met(self) -> bool:
        """Whether the interpreter in use has this very version."""
        try:
            return metadata.version(self.name) == self.version
        except metadata.PackageNotFoundError:
            return False


@dataclass(frozen=True, slots=True)
class Amount:
    """How much an installation fetches: number of distributions, bytes of their files, and bytes on disk."""

    count: int
    size: int
    on_disk: int

    def __str__(self) -> str:
        """In words, for a person who decides whether now is the time."""
        noun = "distribution" if self.count == 1 else "distributions"
        fetched, kept = (max(round(size / 1e6), 1) for size in (self.size, self.on_disk))
        return f"{self.count} {noun}, {fetched} MB to download, about {kept} MB on disk"


def locked_file(part: str) -> Path:
    """Path of the requirements with hashes of a part: ``core``, an extra, or ``dev``; each holds the core too."""
    return FOLDER / f"{part}.txt"


def pins(part: str) -> tuple[Pin, ...]:
    """List the distributions of a part that apply to this machine."""
    matches = map(_PIN.match, locked_file(part).read_text(encoding="utf-8").splitlines())
    return tuple(Pin(m["name"], m["version"]) for m in matches if m and applies(m["marker"]))


def amount(part: str, *, again: bool = False) -> Amount:
    """Return what is still to be fetched of a part, or all of it ``again``, by the sizes that uv.lock holds."""
    packages = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))["package"]
    known = {(p["name"], p.get("version")): p for p in packages}
    lacking = [pin for pin in pins(part) if again or not pin.met]
    fetched = {pin.name: _size(known[pin.name, pin.version]) for pin in lacking}
    measured = json.loads(SIZES.read_text(encoding="utf-8")) if SIZES.is_file() else {}
    on_disk = sum(measured.get(name, _UNPACKED * size) for name, size in fetched.items())
    return Amount(len(lacking), sum(fetched.values()), on_disk)


def _size(package: dict[str, Any]) -> int:
    """Bytes of the file that an installer takes: a wheel for this machine, else the source."""
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
