"""Options of the commands that run foreign FMUs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from haptid.identification.thresholds import THRESHOLDS

F = TypeVar("F", bound=Callable[..., Any])


def model_option(meaning: str) -> Callable[[F], F]:
    """Return the option ``--model`` of a command.

    Parameters
    ----------
    meaning
        What the command does with the FMU.

    Returns
    -------
    callable
        Decorator of a click command, which then takes the argument ``model``: a path, or None where left out.
    """
    return click.option(
        "--model",
        type=click.Path(path_type=Path, dir_okay=False),
        default=None,
        metavar="ANY.fmu",
        help=f"{meaning} The one that campaign.toml names where left out.",
    )


limit_option = click.option(
    "--simulation-limit",
    "limit_s",
    type=click.FloatRange(min=0.1),
    default=THRESHOLDS.longest_simulation_s,
    show_default=True,
    metavar="SECONDS",
    help="Of an FMU: longest wait for one simulation.",
)
