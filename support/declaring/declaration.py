"""Commands declared apart from their work, so that help comes without importing it, and ``--json`` for their results.

A module ``commands`` of a package holds the declarations; the work is imported when a command is called.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout
from types import ModuleType
from typing import Any, ParamSpec

import click

from haptid.support.declaring.usage import OneLineCommand
from haptid.support.errors import HaptidError, InputError
from haptid.support.files.files import json_text
from haptid.support.interrupts import no_interrupt_is_lost
from haptid.support.numbers import read_number
from haptid.support.terminal import is_terminal
from haptid.version import version_option

P = ParamSpec("P")


def number_of_option(ctx: click.Context, param: click.Parameter, value: str | None) -> float | None:
    """Read the number of an option, or a product as ``2*pi/4096``: what a dialogue takes, a script may write too.

    Parameters
    ----------
    ctx, param
        The option, for the error.
    value
        Text of the command line; None where the option is left out.

    Returns
    -------
    float or None

    Raises
    ------
    click.BadParameter
        Where the text is no number.
    """
    if value is None:
        return None
    try:
        return read_number(value)
    except ValueError:
        msg = f"{value!r} is not a valid float"
        raise click.BadParameter(msg, ctx, param) from None


class IncompleteError(HaptidError):
    """A command did what it could, and has told what failed: exit code 1, with the result under ``--json``.

    Parameters
    ----------
    sentence
        What failed, in one line.
    result
        Result as a value for JSON.
    """

    def __init__(self, sentence: str, result: Any) -> None:
        super().__init__(sentence)
        self.result = result


def command(examples: str, writes: Mapping[str, str]) -> Callable[[Callable[..., Any]], click.Command]:
    """Decorate a function that becomes a command whose help ends with examples, with the option ``--version``.

    Parameters
    ----------
    examples
        Command lines, one a line, as a user types them.
    writes
        What each file holds that the command writes, by its name below ``--out``.

    Returns
    -------
    callable
        Decorator that returns the click command.
    """
    # The control character keeps click from wrapping the lines that follow.
    shown = "\b\nExamples:" + "".join(f"\n  {line.strip()}" for line in examples.strip().splitlines())
    width = max(map(len, writes), default=0)
    files = "".join(f"\n  {name.ljust(width)}  {content}" for name, content in writes.items())
    settings = {"help_option_names": ["-h", "--help"]}

    def decorate(function: Callable[..., Any]) -> click.Command:
        told = inspect.cleandoc(function.__doc__ or "") + (f"\n\n\b\nWritten below --out:{files}" if writes else "")
        decorator = click.command(cls=OneLineCommand, help=told, epilog=shown, context_settings=settings)
        return decorator(version_option(function))

    return decorate


LOADING = "loading …"
"""First word of a command that takes its time, within half a second."""


def call(module: str, function: str, **settings: Any) -> Any:
    """Import the work of a command and do it.

    Parameters
    ----------
    module
        Module of the work, as in ``haptid.identification.run``.
    function
        Function in it.
    settings
        Values of the command's arguments and options.

    Returns
    -------
    Any
        What the function returns: the result as a value for JSON.

    Raises
    ------
    InputError
        Where a package is not installed that the work imports.
    """
    # In a log nothing stands before an error, which is one line.
    told = is_terminal(sys.stderr) and not settings.get("quiet", False)
    with _show_loading() if told else nullcontext(), no_interrupt_is_lost():
        loaded = _import_work(module)
    return getattr(loaded, function)(**settings)


def _import_work(module: str) -> ModuleType:
    """Import the work of a command; a package that the core needs and the environment lacks is one line."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing in ("", "haptid"):  # a fault of haptid itself, which its traceback tells
            raise
        todo = "install haptid again with its requirements (pip install haptid, or make in a clone)"
        expected = f"the package {missing}, which haptid needs"
        raise InputError(sys.executable, expected=expected, got="none in this environment", todo=todo) from None


@contextmanager
def _show_loading() -> Iterator[None]:
    """Say that packages are loaded, which takes seconds; the terminal forgets the words afterwards."""
    click.echo(LOADING, err=True, nl=False)
    try:
        yield
    finally:
        click.echo(f"\r{' ' * len(LOADING)}\r", err=True, nl=False)


def json_option(function: Callable[P, Any]) -> Callable[P, None]:
    """Add ``--json`` to a command: its result on stdout as one JSON document, everything else on stderr.

    Parameters
    ----------
    function
        Command that returns its result as a value for JSON.

    Returns
    -------
    callable
        Command with the option, that returns nothing.
    """

    @functools.wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        if not kwargs.pop("as_json"):
            function(*args, **kwargs)
            return
        try:
            with redirect_stdout(sys.stderr):  # the summary is for people, and goes where progress goes
                result = function(*args, **kwargs)
        except IncompleteError as error:
            click.echo(json_text(error.result), nl=False)
            raise
        click.echo(json_text(result), nl=False)

    words = "Print the result on stdout as one JSON document; summary and progress go to stderr."
    return click.option("--json", "as_json", is_flag=True, help=words)(wrapped)
