"""Which interpreter can run the project: its own requirements read from pyproject.toml, the project's .venv beside it.

Standard library only: this runs before anything is installed.
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent.parent
VENV_PYTHON = ROOT / ".venv" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
BAD_SETUP = 2

_REQUIREMENT = re.compile(r"^(?P<name>[\w.-]+)\s*(\[[^]]*\])?\s*(?P<bounds>[^;]*?)\s*(;\s*(?P<marker>.*))?$")
_MARKER = re.compile(r"^(platform_machine|sys_platform)\s*(==|!=)\s*['\"]([^'\"]*)['\"]$")


@dataclass(frozen=True, slots=True)
class Requirement:
    """One line of pyproject's dependencies: ``text`` as written, name, and bounds as (operator, version) pairs."""

    text: str
    name: str
    bounds: tuple[tuple[str, tuple[int, ...]], ...]

    @property
    def met(self) -> bool:
        """Whether the interpreter in use has it, in a version within the bounds."""
        try:
            installed = _version(metadata.version(self.name))
        except metadata.PackageNotFoundError:
            return False
        return all(_holds(installed, operator, bound) for operator, bound in self.bounds)


def _version(text: str) -> tuple[int, ...]:
    """Leading numbers of a version: ``1.10.0rc1`` is (1, 10, 0)."""
    match = re.match(r"\d+(\.\d+)*", text)
    return tuple(int(part) for part in match[0].split(".")) if match else ()


def _holds(installed: tuple[int, ...], operator: str, bound: tuple[int, ...]) -> bool:
    width = max(len(installed), len(bound))
    a, b = ((*v, *(0,) * (width - len(v))) for v in (installed, bound))
    return {">=": a >= b, ">": a > b, "<": a < b, "<=": a <= b, "==": a == b, "!=": a != b}[operator]


def _applies(marker: str | None) -> bool:
    """Evaluate the one form of marker that pyproject uses; a richer one counts as true and is left to the installer."""
    match = _MARKER.match(marker or "")
    if match is None:
        return True
    name, operator, value = match.groups()
    here = {"platform_machine": platform.machine(), "sys_platform": sys.platform}[name]
    return (here == value) == (operator == "==")


def parse_requirement(text: str) -> Requirement | None:
    """Read one requirement; None where its marker does not apply to this machine."""
    match = _REQUIREMENT.match(text)
    if match is None:
        msg = f"pyproject.toml: cannot read the requirement {text!r}"
        raise ValueError(msg)
    if not _applies(match["marker"]):
        return None
    bounds = re.findall(r"([<>=!]=|[<>])\s*([^,\s]+)", match["bounds"])
    return Requirement(text, match["name"], tuple((operator, _version(version)) for operator, version in bounds))


def requirements(*, dev: bool) -> tuple[Requirement, ...]:
    """Read the project's requirements that apply here, those of its development tools too where ``dev``."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    lines = project["project"]["dependencies"] + (project["dependency-groups"]["dev"] if dev else [])
    return tuple(r for r in map(parse_requirement, lines) if r is not None)


def missing(*, dev: bool = False) -> tuple[Requirement, ...]:
    """List the requirements that the interpreter in use does not meet."""
    return tuple(r for r in requirements(dev=dev) if not r.met)


def replace_process(arguments: Sequence[str | Path]) -> NoReturn:
    """Become ``arguments``; where the system cannot, run them and leave with their exit code."""
    command = [str(a) for a in arguments]
    if sys.platform == "win32":
        sys.exit(subprocess.run(command, check=False).returncode)
    os.execv(command[0], command)


def in_venv() -> bool:
    """Whether the interpreter in use is that of the project's .venv."""
    return Path(sys.prefix).resolve() == (ROOT / ".venv").resolve()


def ready() -> None:
    """Let ``python -m package.command`` run under an interpreter that has the requirements, or say what to type.

    Packages that hold a command call this when they are imported. It acts only while ``python -m`` looks for the
    command (``sys.argv[0]`` is then ``-m``), so that it costs a library import nothing.
    """
    if sys.argv[:1] != ["-m"]:
        return
    lacking = missing()
    if not lacking:
        return
    if VENV_PYTHON.is_file() and not in_venv():
        options = sys.orig_argv[1:]
        replace_process([VENV_PYTHON, *options])
    sys.stderr.write(f"error: {sys.executable} lacks {', '.join(r.name for r in lacking)}; run `make fmu` first\n")
    sys.exit(BAD_SETUP)
