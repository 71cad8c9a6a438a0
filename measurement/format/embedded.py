"""The campaigns that come with the package: name in, folder out, and the option ``--campaign`` that names one.

``planned`` holds the runs of ``paper``, and tests in the lock postures that `model.planning` proposes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import click

from haptid.support.errors import InputError
from haptid.support.suggestion import did_you_mean

Embedded = Literal["planned", "paper"]
"""Name of an embedded campaign."""
FOLDERS: dict[Embedded, str] = {"planned": "freedom6s_planned", "paper": "freedom6s"}
"""Folder of each embedded campaign, the default first."""
DEFAULT: Embedded = "planned"
OPTION = "--campaign"


def embedded_campaign(name: str = DEFAULT) -> Path:
    """Find a Freedom 6S campaign that comes with the package.

    Parameters
    ----------
    name
        ``planned``: locked-joint tests after Table III of Tam, Kubica and Wang (2005), and tests in the lock postures
        that the plan proposes. ``paper``: the tests of the paper alone.

    Returns
    -------
    Path
        Its folder.

    Raises
    ------
    InputError
        Where there is no such campaign.
    """
    for known, folder in FOLDERS.items():
        if known == name:
            return Path(str(files("haptid.measurement") / "campaigns" / folder))
    expected = f"an embedded campaign ({', '.join(FOLDERS)})"
    raise InputError(OPTION, expected=expected, got=repr(name), todo=did_you_mean(name, tuple(FOLDERS)))


def name_of(folder: Path) -> Embedded | None:
    """Return the name of an embedded campaign.

    Parameters
    ----------
    folder
        Folder of any campaign.

    Returns
    -------
    str or None
        None for a campaign that does not come with the package.
    """
    return next((name for name in FOLDERS if embedded_campaign(name).resolve() == folder.resolve()), None)


def choose_campaign(folder: Path | str | None, embedded: str | None) -> Path | str | None:
    """Return the campaign that a user asks for by its folder or, where it is embedded, by its name.

    Parameters
    ----------
    folder
        Folder of any campaign; None for an embedded one.
    embedded
        Name of an embedded campaign; None where ``folder`` says which, or for the default.

    Returns
    -------
    Path or str or None
        Folder; None where neither is given.

    Raises
    ------
    InputError
        Where both are given, or there is no such embedded campaign.
    """
    if embedded is None:
        return folder
    if folder is not None:
        got, todo = repr(str(folder)), "leave one of them out"
        raise InputError(OPTION, expected="no CAMPAIGN beside it", got=got, todo=todo)
    return embedded_campaign(embedded)


def embedded_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the option ``--campaign`` to a click command with an optional argument CAMPAIGN.

    Parameters
    ----------
    command
        Function that becomes the command; it gets the folder as ``campaign``, None where neither is given.

    Returns
    -------
    callable
        The same function with the option. It raises `InputError` where both are given.
    """

    @functools.wraps(command)
    def wrapped(*args: Any, campaign: Path | str | None, embedded: Embedded | None, **kwargs: Any) -> Any:
        return command(*args, campaign=choose_campaign(campaign, embedded), **kwargs)

    words = f"Embedded campaign to take where CAMPAIGN is left out. [default: {DEFAULT}]"
    return click.option(OPTION, "embedded", type=click.Choice([*FOLDERS]), default=None, help=words)(wrapped)
