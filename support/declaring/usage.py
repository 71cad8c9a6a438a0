"""Errors of a command line in the one line that all errors of haptid are, instead of click's three."""

from __future__ import annotations

import re
from typing import IO, Any

import click

from haptid.support.errors import LONGEST, one_line, shorten

DECIMAL_COMMA = re.compile(r"'[+-]?\d*,\d+'")
"""A quoted number with a decimal comma."""


class UsageLine(click.UsageError):
    """A wrong command line: one line ``error: …`` on stderr, exit code 2."""

    def show(self, file: IO[Any] | None = None) -> None:
        """Write the line.

        Parameters
        ----------
        file
            Stream; standard error where None.
        """
        command = self.ctx.command_path if self.ctx is not None else "haptid"
        message = one_line(self.format_message()).rstrip(".")
        told = f"{command}: {message[:1].lower()}{message[1:]}"
        todo = "; write a decimal point" if DECIMAL_COMMA.search(message) else ""
        todo += f"; see {command} --help"
        click.echo(f"error: {shorten(told, LONGEST - len(todo))}{todo}", file=file, err=file is None)


def in_one_line(error: click.UsageError) -> click.UsageError:
    """Return the error of a wrong command line that shows itself in one line.

    Parameters
    ----------
    error
        As click raised it.

    Returns
    -------
    click.UsageError
        A `UsageLine`; the error itself where a call without arguments is to show the help.
    """
    if isinstance(error, UsageLine) or type(error).__name__ == "NoArgsIsHelpError":  # the latter of click 8.2 on
        return error
    return UsageLine(error.format_message(), error.ctx)


class OneLineCommand(click.Command):
    """A command whose wrong arguments end in one line."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Parse the arguments, as click does.

        Parameters
        ----------
        info_name, args, parent, extra
            As click has them.

        Returns
        -------
        click.Context
        """
        try:
            return super().make_context(info_name, args, parent, **extra)
        except click.UsageError as error:
            raise in_one_line(error) from None
