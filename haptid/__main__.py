"""``python -m haptid COMMAND``."""

from haptid.command_line import main

main(prog_name="haptid")
