"""What all calls of the API share: errors that name arguments, who listens, and the joint that is meant."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from numbers import Integral
from typing import Protocol

from haptid.measurement.values.campaign import Campaign
from haptid.support.command import listening
from haptid.support.errors import InputError
from haptid.support.listener import Listener
from haptid.support.terminal import is_watched

ARGUMENTS = {"out": "folder", "map": "columns", "with": "findings", "free": "joint", "effects": "own_effects"}
"""Argument of the API by option of the commands, where their names differ."""
_MAPS = re.compile(r"--map '[^']*'(?: --map '[^']*')*")
_MAP = re.compile(r"'([^']*)=([^'=]*)'")
_OPTION = re.compile(r"--([a-z][a-z-]*)")
_COMMAND = re.compile(r"haptid [a-z]|python -m ")


@contextmanager
def errors_name_arguments() -> Iterator[None]:
    """Name arguments instead of the commands' options in the input errors of the block.

    Raises
    ------
    InputError
        As the block does, in the words of a Python program.
    """
    try:
        yield
    except InputError as error:
        where, expected, got = (_name_arguments(text) for text in (error.where, error.expected, error.got))
        todo = _name_arguments(error.todo, tail="=")  # a remedy says what to write
        raise InputError(where, expected=expected, got=got, todo=todo) from None


def _name_arguments(text: str, tail: str = "") -> str:
    if _COMMAND.search(text):  # a command that the user may type keeps its options
        return text
    text = _MAPS.sub(lambda found: _columns_argument(found[0]), text)
    return _OPTION.sub(lambda found: ARGUMENTS.get(found[1], found[1].replace("-", "_")) + tail, text)


def _columns_argument(maps: str) -> str:
    """Return ``--map 'a=b' --map 'c=d'`` as the argument of a call."""
    pairs = ", ".join(f'"{column}": "{target}"' for column, target in _MAP.findall(maps))
    return f"columns={{{pairs}}}"


@contextmanager
def listener_of(progress: bool | Listener | None) -> Iterator[Listener]:
    """Hand who listens to a computation to the block.

    Parameters
    ----------
    progress
        True for a progress bar on stderr, False for nobody, None for a bar where somebody watches (`is_watched`), or a
        listener. Remarks and warnings are in the results.

    Yields
    ------
    Listener
        The given one, or one whose bar ends with the block.
    """
    if isinstance(progress, Listener):
        yield progress
    else:
        wanted = is_watched(sys.stderr) if progress is None else progress
        with listening(quiet=not wanted) as shown:
            yield Listener(progress=shown.progress)


class HoldsCampaign(Protocol):
    """Anything that holds a campaign: `haptid.Campaign`."""

    @property
    def values(self) -> Campaign:
        """The campaign as all packages take it."""


def check_choice(argument: str, got: object, choices: Sequence[str]) -> None:
    """Refuse a word that an argument does not take.

    Parameters
    ----------
    argument
        Name of the argument.
    got
        What the caller gave.
    choices
        Words that it takes.

    Raises
    ------
    InputError
        Where ``got`` is none of them.
    """
    if got not in choices:
        raise InputError(argument, expected=f"one of {', '.join(choices)}", got=repr(got), todo="name one of these")


def joints_of(argument: str, given: int | Sequence[int] | None) -> tuple[int, ...] | None:
    """Return the numbers of joints that the caller gave.

    Parameters
    ----------
    argument
        Name of the argument.
    given
        A number, several, or None.

    Returns
    -------
    tuple of int or None
        In the order of the caller; None for None.

    Raises
    ------
    InputError
        Where something else was given, as the name of a joint.
    """
    if given is None:
        return None
    numbers = [given] if isinstance(given, Integral) else given
    # A text is a sequence of letters, each of which would be taken for a joint.
    if isinstance(numbers, str) or not isinstance(numbers, Iterable):
        raise _no_joints(argument, given)
    joints = list(numbers)
    if not all(isinstance(joint, Integral) for joint in joints):
        raise _no_joints(argument, given)
    return tuple(int(joint) for joint in joints)


def _no_joints(argument: str, given: object) -> InputError:
    todo = "joints are named by the numbers of their columns, as 0 of torque_0_Nm"
    return InputError(argument, expected="a number of a joint, or several as in (0, 1)", got=repr(given), todo=todo)


def only_one(wanted: int | None, known: Sequence[int]) -> int:
    """Return the joint that is meant.

    Parameters
    ----------
    wanted
        Number of a joint; None for the only one.
    known
        Joints to choose from.

    Returns
    -------
    int

    Raises
    ------
    InputError
        Where there is no such joint, or several and none is named.
    """
    if wanted is None and len(known) == 1:
        return known[0]
    if wanted is None or wanted not in known:
        there = ", ".join(map(str, known)) or "none"
        raise InputError("joint", expected=f"one of the joints {there}", got=str(wanted))
    return wanted
