"""The version of this haptid, read without importing any of its packages."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def version() -> str:
    """Find the version of the installed haptid, or that of a clone that is run in place.

    Returns
    -------
    str
        As ``0.1.0``, with ``, in a clone`` after that of a clone.
    """
    from importlib import metadata  # noqa: PLC0415 (30 ms, which no help needs)

    try:
        return metadata.version("haptid")
    except metadata.PackageNotFoundError:
        project = (Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8")
        stated = re.search(r'^version = "(.+)"$', project, re.MULTILINE)
        return f"{stated[1] if stated else 'unknown'}, in a clone"


def version_option(function: F) -> F:
    """Add ``--version`` to a command; the version is looked up when it is asked for.

    Parameters
    ----------
    function
        Command that click declares.

    Returns
    -------
    callable
        The same command with the option.
    """
    return click.option(
        "--version",
        is_flag=True,
        expose_value=False,
        is_eager=True,
        callback=_tell_version,
        help="Show the version and exit.",
    )(function)


def _tell_version(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value and not context.resilient_parsing:
        click.echo(f"haptid, version {version()}")
        context.exit()
