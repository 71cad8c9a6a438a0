"""Where the files that a campaign names lie: inside its folder, unless the user allows more."""

from __future__ import annotations

from pathlib import Path

from support.errors import InputError
from support.files import is_file

ALLOW_OUTSIDE = "--allow-outside"


def lies_outside(folder: Path, name: str) -> bool:
    """Whether ``name`` leads out of ``folder``, be it by "..", as an absolute path or through a link."""
    try:
        return not (folder / name).resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # RuntimeError: links in a circle
        return False


def refuse_outside(folder: Path, name: str, where: str) -> None:
    """Raise where the file ``name`` exists and leads out of the campaign's ``folder``."""
    if lies_outside(folder, name) and is_file(folder / name):
        todo = f"copy it into the campaign, or allow it with {ALLOW_OUTSIDE}"
        expected = "a file inside the campaign's folder"
        raise InputError(where, expected=expected, got=f"{name!r}, which leads out of it", todo=todo)
