"""What the shell completes where an argument is a file, a device or a table; nothing is imported before it is asked.

Functions for ``shell_complete=`` of click: unlike a type of click, they change no error of a command.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

SUFFIXES = (".toml", ".urdf")
"""Ends of a device's file."""
_PLAIN = re.compile(r"[\w.+-]+")
"""Names that a shell takes as they are; others it completes itself, with quotes."""


def complete_files(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:  # noqa: ARG001 # click's signature
    """Let the shell complete files and folders.

    Parameters
    ----------
    ctx, param
        What is completed; they have no influence.
    incomplete
        What the user typed of it.

    Returns
    -------
    list of CompletionItem
    """
    from click.shell_completion import CompletionItem  # noqa: PLC0415 (help comes without it)

    return [CompletionItem(incomplete, type="file")]


def complete_device(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete built-in devices, then device files; where no name of these begins so, the shell completes files.

    Parameters
    ----------
    ctx
        Context of the call: where the command has an argument FOLDER, device files there count, too.
    param, incomplete
        As `complete_files` takes them.

    Returns
    -------
    list of CompletionItem
    """
    names = [*_built_in(), *(name for name in _names_in(_folder(ctx)) if _is_device(name))]
    if not any(name.startswith(incomplete) for name in names):
        return complete_files(ctx, param, incomplete)
    # Bash completes no files beside given names: those of this folder are given as well.
    here = [name for name in _names_in(Path()) if _is_device(name) or name.endswith("/")]
    return _items([*names, *here], incomplete)


def complete_table(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete the names of files in the argument FOLDER of the command.

    Parameters
    ----------
    ctx
        Context of the call.
    param, incomplete
        As `complete_files` takes them.

    Returns
    -------
    list of CompletionItem
    """
    names = [name for name in _names_in(_folder(ctx)) if not name.endswith("/")]
    return _items(names, incomplete) or complete_files(ctx, param, incomplete)


def _items(names: list[str], incomplete: str) -> list[CompletionItem]:
    from click.shell_completion import CompletionItem  # noqa: PLC0415 (help comes without it)

    return [CompletionItem(name) for name in dict.fromkeys(names) if name.startswith(incomplete)]


def _built_in() -> list[str]:
    """List the built-in devices, as `haptid.model.device.reader.builtin_devices` does, without importing a package."""
    folder = resources.files("haptid") / "model" / "device" / "built_in"
    return sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".toml"))


def _is_device(name: str) -> bool:
    return name.endswith(SUFFIXES) and name != "campaign.toml"


def _folder(ctx: click.Context) -> Path | None:
    """Return the argument FOLDER; click leaves it among the rest where the last option's value is still to come."""
    folder = ctx.params.get("folder") or next(iter(ctx.args), None)
    return None if folder is None else Path(folder)


def _names_in(folder: Path | None) -> Iterator[str]:
    """List what is in a folder by name, folders with a slash at the end; nothing where it cannot be read."""
    entries: list[Path] = []
    if folder is not None:
        with suppress(OSError):
            entries = sorted(folder.iterdir())
    for entry in entries:
        if _PLAIN.fullmatch(entry.name) and not entry.name.startswith("."):
            yield f"{entry.name}/" if entry.is_dir() else entry.name
