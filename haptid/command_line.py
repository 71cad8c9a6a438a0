"""``haptid COMMAND``: one door to all commands; each is loaded when it is asked for, so that help comes at once."""

from __future__ import annotations

import importlib
from difflib import get_close_matches
from typing import Any

import click

from haptid.version import version_option

COMMANDS = {
    "init": ("measurement.commands", "Make a campaign from a folder of tables."),
    "check": ("measurement.commands", "Read a campaign and say what is in it, and what looks like a slip."),
    "plan": ("model.commands", "Which joints to lock, in which order and posture."),
    "fmus": ("fmu_build.commands", "Build one FMU per locked-joint configuration of a device."),
    "identify": ("identification.commands", "Fit joint by joint, verify the whole device, export its FMU."),
    "posterior": ("uq.commands", "How well each parameter is known."),
    "missing": ("discrepancy.commands", "What is missing in the model of a joint, if anything."),
    "export": ("fmu_build.commands", "Package an identified model again."),
    "report": ("report.commands", "Write the pages of stored results again, without fitting."),
    "fleet": ("commands", "Identify several devices and compare their parameters."),
    "doctor": ("commands", "Check Python, compiler, cache, disk, extras, a kernel and an FMU."),
}
"""Name: the module that declares the command under this name, and what it does."""

EXTRAS = {"posterior": "posterior"}
"""Commands whose packages need an extra before they can be imported."""

EXAMPLES = """\b
Examples:
  haptid init my_tables --out my_campaign
  haptid check my_campaign
  haptid identify my_campaign --out results
  haptid posterior my_campaign --out results --joints 4
  haptid missing my_campaign --out results --joint 4
  haptid fleet all_campaigns --out fleet --workers 2
"""


class Commands(click.Group):
    """A group whose commands are imported when they are called."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Parse what stands before the command, as click does, with errors in one line.

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
            from haptid.support.declaring.usage import in_one_line  # noqa: PLC0415 (help comes without any import)

            raise in_one_line(error) from None

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 # click's signature
        """List the commands without importing any.

        Parameters
        ----------
        ctx
            Context of the call; it has no influence.

        Returns
        -------
        list of str
            Names in the order in which a user needs them.
        """
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # click's signature
        """Import a command; where its extra is missing, say so and end.

        Parameters
        ----------
        ctx
            Context of the call.
        cmd_name
            Name that the user typed.

        Returns
        -------
        click.Command or None
            None for an unknown name.
        """
        if cmd_name not in COMMANDS:
            return None
        if cmd_name in EXTRAS and not ctx.resilient_parsing:  # a shell that completes names needs no extra
            _need(EXTRAS[cmd_name], cmd_name, ctx)
        command = getattr(importlib.import_module(f"haptid.{COMMANDS[cmd_name][0]}"), cmd_name)
        return command if isinstance(command, click.Command) else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Refuse an unknown command in one line, with the one it may have meant.

        Parameters
        ----------
        ctx
            Context of the call; an unknown command ends it with exit code 2.
        args
            Name of the command and its arguments.

        Returns
        -------
        tuple
            Name, command, and the arguments left for it, as click's own.
        """
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            near = get_close_matches(args[0], COMMANDS, n=1)
            meant = f"; did you mean {near[0]}?" if near else ""
            click.echo(f"error: haptid: expected one of {', '.join(COMMANDS)}, got {args[0][:60]!r}{meant}", err=True)
            ctx.exit(2)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002 # click's signature
        """Write the list of commands without importing any.

        Parameters
        ----------
        ctx
            Context of the call; it has no influence.
        formatter
            Help text that the list is added to.
        """
        with formatter.section("Commands"):
            formatter.write_dl([(name, told) for name, (_, told) in COMMANDS.items()])


def _need(extra: str, command: str, ctx: click.Context) -> None:
    """Leave in one line where an extra is not installed."""
    from haptid.support.errors import InputError  # noqa: PLC0415 (help comes without any import)
    from haptid.support.installing.extras import need  # noqa: PLC0415 (the same)

    try:
        need(extra, f"haptid {command}")
    except InputError as error:
        click.echo(f"error: {error}", err=True)
        ctx.exit(2)


@click.command(cls=Commands, epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]})
@version_option
def main() -> None:
    """Turn measurements of a robot or haptic device into identified FMUs with honest uncertainty."""
