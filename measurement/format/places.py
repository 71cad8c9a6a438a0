"""Keep the files that a campaign names inside its folder, unless the user gives ``--allow-outside``.

A campaign may come from a stranger: its tables and devices must not make a command read other files of the user.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TypeVar

import click

from haptid.measurement.values.warning import warn
from haptid.support.errors import InputError, shorten
from haptid.support.files.files import is_file

F = TypeVar("F", bound=Callable[..., object])
OPTION = "--allow-outside"
_allowed: ContextVar[bool] = ContextVar("outside_allowed", default=False)


def allow_outside_option(command: F) -> F:
    """Add the option ``--allow-outside`` to a click command that reads a campaign.

    Parameters
    ----------
    command
        Function that becomes the command; it gets no argument for the option.

    Returns
    -------
    callable
        The same function with the option, which holds until the command ends.
    """

    def set_allowed(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
        context.with_resource(outside_allowed(value))

    words = "Let the campaign name files outside its folder."
    return click.option(OPTION, is_flag=True, expose_value=False, callback=set_allowed, help=words)(command)


@contextmanager
def outside_allowed(value: bool = True) -> Iterator[None]:
    """Allow campaigns that are read in this context to name files outside their folders, with a warning.

    Parameters
    ----------
    value
        False refuses such files, as outside this context.
    """
    token = _allowed.set(value)
    try:
        yield
    finally:
        _allowed.reset(token)


def check_inside(folder: Path, name: str, where: str) -> None:
    """Refuse the file ``name`` where it leads out of ``folder`` by "..", as an absolute path or through a link.

    Parameters
    ----------
    folder
        Folder of the campaign.
    name
        File as ``campaign.toml`` names it.
    where
        Place of the name in ``campaign.toml``, for errors and warnings.

    Raises
    ------
    InputError
        Where that file exists and ``--allow-outside`` was not given; with it, a warning says what lies outside.
    """
    if not is_file(folder / name):
        return
    target = (folder / name).resolve()
    if target.is_relative_to(folder.resolve()):
        return
    if not _allowed.get():
        expected, got = "a file inside the campaign's folder", f"{shorten(name, 60)!r} outside"
        raise InputError(where, expected=expected, got=got, todo=f"copy it there, or allow it by {OPTION}")
    warn(f"{where}: {name!r} lies outside the campaign's folder, at {target}")
