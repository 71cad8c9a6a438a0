"""``python -m haptid COMMAND``, and the installed ``haptid COMMAND``."""

from __future__ import annotations

from haptid.support.interrupts import end_at_interrupt


def main() -> None:
    """Run a command; where a package lacks that the command line itself needs, or Ctrl-C comes, say so in one line."""
    end_at_interrupt()
    # What is not needed is not imported: help comes at once.
    try:
        from haptid.command_line import main as command_line  # noqa: PLC0415 # needs click
    except ModuleNotFoundError:
        from haptid.support.installing.environment import exit_where_lacking  # noqa: PLC0415 # needs nothing

        exit_where_lacking()
        raise
    command_line(prog_name="haptid")


if __name__ == "__main__":
    main()
