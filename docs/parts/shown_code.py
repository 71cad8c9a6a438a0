"""What pages show as code: Markdown in; command lines and blocks by language out. The tests check them."""

from __future__ import annotations

import importlib
import importlib.util
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click

from haptid.command_line import main as haptid
from haptid.support.installing.environment import ROOT

BLOCK = re.compile(r"^```(?P<language>\w*)\n(?P<code>.*?)^```", re.DOTALL | re.MULTILINE)
SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
COMMAND = re.compile(r"^(?:haptid [a-z-]|python -m \w)")
SHELLS = ("", "bash")
"""Languages of blocks that hold command lines, or what a command prints."""
PLACEHOLDER = re.compile(r"…|\.\.\.|^[A-Z][A-Z_,:0-9]*$")
"""Words that stand for what the reader puts in."""
ENDS_OF_COMMAND = ("|", "&&", ";", ">", "<", "||")


def blocks_of(page: Path, *languages: str) -> list[str]:
    """Return the fenced blocks of a page.

    Parameters
    ----------
    page
        Markdown file.
    *languages
        Languages of the blocks; an empty one for blocks that state none.

    Returns
    -------
    list of str
        In the order of the page.
    """
    text = page.read_text(encoding="utf-8")
    return [found["code"] for found in BLOCK.finditer(text) if found["language"] in languages]


def commands_of(page: Path) -> list[list[str]]:
    """Return the commands of haptid, and of its modules, that a page shows in blocks and within sentences.

    Parameters
    ----------
    page
        Markdown file.

    Returns
    -------
    list of list of str
        Words of each, without comments, pipes and what stands for the reader's own.
    """
    lines = [line for block in blocks_of(page, *SHELLS) for line in block.splitlines()]
    lines += SPAN.findall(BLOCK.sub("", page.read_text(encoding="utf-8")))
    return [words for line in lines for words in _simple_commands(line)]


def _simple_commands(line: str) -> Iterator[list[str]]:
    """Yield the commands of a line that haptid has to know."""
    try:
        words = shlex.split(line, comments=True)
    except ValueError:  # a quotation mark of a sentence
        return
    own: list[str] = []
    for word in [*words, ";"]:
        if word in ENDS_OF_COMMAND:
            if COMMAND.match(" ".join(own)):
                yield own
            own = []
        else:
            own.append(word)


def check_command(words: list[str]) -> None:
    """Parse a command line without running it.

    Parameters
    ----------
    words
        As `commands_of` returns them.

    Raises
    ------
    click.UsageError
        Where there is no such command or option, an option lacks its value, or a value is none that it takes.
    LookupError
        Where there is no such module.
    """
    found = _command(words)
    if found is None:
        return
    command, rest = found
    context = click.Context(command, info_name=command.name)
    options, surplus, _ = command.make_parser(context).parse_args(list(rest))
    if any(not PLACEHOLDER.search(word) for word in surplus):
        context.fail(f"{' '.join(words)}: more arguments than the command takes")
    for parameter in command.get_params(context):
        value = options.get(parameter.name or "")
        if isinstance(value, str) and not PLACEHOLDER.search(value) and not isinstance(parameter.type, click.Path):
            parameter.type_cast_value(context, value)


def _command(words: list[str]) -> tuple[click.Command, list[str]] | None:
    """Return the command and its arguments; None for a module that is not haptid's."""
    if words[0] == "haptid":
        door = click.Context(haptid, info_name="haptid")
        if words[1].startswith("-"):
            return haptid, words[1:]
        command = haptid.get_command(door, words[1])
        if command is None:
            door.fail(f"no command haptid {words[1]}")
        return command, words[2:]
    name = words[2]
    if importlib.util.find_spec(f"haptid.{name.partition('.')[0]}") is not None:
        name = f"haptid.{name}"  # the one name under which packages are imported
    elif not (ROOT / name.partition(".")[0]).is_dir():
        return None  # a module of another project
    if importlib.util.find_spec(name) is None:
        msg = f"python -m {words[2]}: no such module"
        raise LookupError(msg)
    command = getattr(importlib.import_module(name), "main", None)
    return (command, words[3:]) if isinstance(command, click.Command) else None
