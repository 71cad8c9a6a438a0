"""Where a result comes from: `FitOptions` and the words of a command in, seed, versions and command out."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import version
from typing import Any

from haptid.identification.problem.options import FitOptions
from haptid.support.command import word_command

PACKAGES = ("numpy", "scipy", "sympy", "fmpy", "pythonfmu", "ziglang")
"""Packages whose versions are written to identification.json."""


def provenance(options: FitOptions, made_by: str) -> dict[str, Any]:
    """Return seed, versions and command.

    Parameters
    ----------
    options
        Choices of the fits.
    made_by
        Command or call.

    Returns
    -------
    dict
        JSON data.
    """
    software = {name: _version(name, "not installed") for name in PACKAGES}
    return {
        "seed": options.seed,
        "software": {"haptid": _version("haptid", "from source"), "python": platform.python_version(), **software},
        "command": made_by,
    }


def word_this_command() -> str:
    """Return the command ``haptid identify`` as the user typed it, with its arguments.

    Returns
    -------
    str
        One line for reports and result files.
    """
    command = word_command("identify", "identification.run")
    # Below haptid the command's own name is the first argument.
    arguments = sys.argv[2:] if command.startswith("haptid") else sys.argv[1:]
    return " ".join((command, *arguments))


def _version(name: str, otherwise: str) -> str:
    try:
        return version(name)
    except ModuleNotFoundError:
        return otherwise
