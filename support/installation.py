"""Installation of the project's requirements by pip or uv: into the interpreter in use, or into the project's .venv.

Standard library only.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from support.environment import (
    BAD_SETUP,
    ROOT,
    VENV_PYTHON,
    Requirement,
    in_venv,
    missing,
    replace_process,
    requirements,
)

BOOTSTRAP = ROOT / "support" / "bootstrap.py"


def fail(message: str) -> NoReturn:
    """Leave with one line on stderr and exit code 2."""
    say(f"error: {message}")
    sys.exit(BAD_SETUP)


def say(message: str) -> None:
    """Write one line of progress to stderr."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def succeeds(*command: str | Path, quiet: bool = False) -> bool:
    """Run a command, its output on stderr or, where ``quiet``, nowhere; True where it left with 0."""
    shown = subprocess.DEVNULL if quiet else None
    try:
        done = subprocess.run([str(c) for c in command], check=False, stdout=shown or sys.stderr, stderr=shown)
    except OSError:
        return False
    return done.returncode == 0


def uv() -> str | None:
    """Path of a uv that runs (the shim of a version manager may not), or None."""
    path = shutil.which("uv")
    return path if path and succeeds(path, "--version", quiet=True) else None


def has_module(name: str) -> bool:
    """Whether the interpreter in use has this module."""
    return importlib.util.find_spec(name) is not None


def can_install_here() -> bool:
    """Whether packages may go into the interpreter in use: nobody else manages it (PEP 668) and it is writable."""
    managed = (Path(sysconfig.get_path("stdlib")) / "EXTERNALLY-MANAGED").exists() and sys.prefix == sys.base_prefix
    return not managed and os.access(sysconfig.get_path("purelib"), os.W_OK)


def _by_venv(folder: Path) -> bool:
    return has_module("ensurepip") and succeeds(sys.executable, "-m", "venv", "--clear", folder)


def _by_uv(folder: Path) -> bool:
    tool = uv()
    return tool is not None and succeeds(
        tool, "venv", "--quiet", "--clear", "--seed", "--python", sys.executable, folder
    )


def _by_outer_pip(folder: Path) -> bool:
    """Fill an environment without pip by the pip outside it (Debian without python3-venv)."""
    return (
        has_module("pip")
        and succeeds(sys.executable, "-m", "venv", "--clear", "--without-pip", folder)
        and succeeds(sys.executable, "-m", "pip", "--python", VENV_PYTHON, "install", "--quiet", "pip")
    )


def make_venv() -> None:
    """Make ``.venv`` with whatever can make one."""
    folder = ROOT / ".venv"
    say(f"{sys.executable} is managed by the system or read-only: making {folder}")
    if not any(make(folder) for make in (_by_venv, _by_uv, _by_outer_pip)):
        fail(
            "no virtual environment can be made; install Python's venv module (Debian: apt install python3-venv) or uv"
        )


def install(wanted: Sequence[Requirement], lacking: Sequence[Requirement]) -> None:
    """Install into the interpreter in use; all requirements are given, so that the installer sees every bound."""
    say(f"installing into {sys.prefix}: {', '.join(r.name for r in lacking)}")
    texts = [r.text for r in wanted]
    tool = uv()
    if tool and succeeds(tool, "pip", "install", "--quiet", "--python", sys.executable, *texts):
        return
    if not has_module("pip") and not succeeds(sys.executable, "-m", "ensurepip", "--default-pip", quiet=True):
        fail(f"{sys.executable} has no pip and cannot get it; install pip or uv")
    if not succeeds(sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *texts):
        fail("the installation failed, as said above; it needs the network this one time")


def say_what_to_type() -> None:
    """Name the interpreter for the next commands where the shell's plain ``python`` is none that can run them."""
    name = shutil.which("python")
    if name is None or not succeeds(name, "-c", "import sys; sys.exit(sys.version_info < (3, 11))", quiet=True):
        shown = VENV_PYTHON.relative_to(ROOT) if in_venv() else Path(sys.executable).name
        say(f"this shell has no `python` of version 3.11 or newer: type `{shown} -m ...` for the other commands")


def run_module(arguments: Sequence[str]) -> NoReturn:
    """Find or make an interpreter that has everything, and become it: ``[--dev] -m module arguments``."""
    dev = arguments[:1] == ["--dev"]
    command = arguments[1:] if dev else arguments
    if command[:1] != ["-m"] or len(command) < 2:
        fail("usage: python support/bootstrap.py [--dev] -m module [arguments]")
    os.chdir(ROOT)
    lacking = missing(dev=dev)
    if lacking and not in_venv():
        if not VENV_PYTHON.is_file() and not can_install_here():
            make_venv()
        if VENV_PYTHON.is_file():
            replace_process([VENV_PYTHON, BOOTSTRAP, *arguments])
    if lacking:
        install(requirements(dev=dev), lacking)
        say_what_to_type()
    replace_process([sys.executable, *command])
