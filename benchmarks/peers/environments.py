"""Environments of the contestants below ``.cache/peers``: made once per list of requirements, by uv or venv and pip."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CACHE = ROOT / ".cache" / "peers"


class NotInstalled(Exception):  # noqa: N818 - told in the table, and no fault of ours
    """An environment could not be made; the text is the installer's last words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Environment:
    """A name and pip requirements; the interpreter is of the version that runs this."""

    name: str
    requirements: tuple[str, ...]

    @property
    def folder(self) -> Path:
        """Where it lies: another list of requirements, another folder."""
        key = f"{sys.version_info[:2]}{sorted(self.requirements)}"
        return CACHE / f"{self.name}_{hashlib.sha256(key.encode()).hexdigest()[:8]}"

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")

    def ready(self) -> Path:
        """Make it where it is not there yet and return its interpreter."""
        done = self.folder / "installed"
        if not done.exists():
            shutil.rmtree(self.folder, ignore_errors=True)
            for command in self._commands():
                finished = subprocess.run(command, capture_output=True, text=True, check=False)
                if finished.returncode != 0:
                    raise NotInstalled((finished.stderr.strip() or finished.stdout.strip())[-300:])
            done.write_text("\n".join(self.requirements))
        return self.python

    def _commands(self) -> tuple[list[str], ...]:
        if shutil.which("uv"):
            make = ["uv", "venv", "--quiet", "--python", sys.executable, str(self.folder)]
            return make, ["uv", "pip", "install", "--quiet", "--python", str(self.python), *self.requirements]
        make = [sys.executable, "-m", "venv", str(self.folder)]
        return make, [str(self.python), "-m", "pip", "install", "--quiet", *self.requirements]


CASADI = Environment(name="casadi", requirements=("casadi==3.8.2", "numpy"))
MODESTPY = Environment(
    name="modestpy", requirements=("modestpy==0.1.1", "fmpy==0.3.15", "pandas<2", "numpy<2", "pyDOE==0.3.8")
)
AMICI = Environment(name="amici", requirements=("amici==1.0.1", "numpy", "scipy", "cmake", "ninja", "swig"))
