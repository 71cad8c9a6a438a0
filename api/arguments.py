"""What all calls of the API share: errors that name arguments, who listens, and the joint that is meant."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from numbers import Integral, Real
from typing import Any, Protocol

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


def names_of_runs(argument: str, given: object, runs: Iterable[str]) -> tuple[str, ...]:
    """Return the names of runs, or patterns of them, that the caller gave.

    Parameters
    ----------
    argument
        Name of the argument.
    given
        One text, several, or None for none.
    runs
        Names of all runs.

    Returns
    -------
    tuple of str

    Raises
    ------
    InputError
        Where something else was given, as the number of a run.
    """
    if given is None:
        return ()
    names = (given,) if isinstance(given, str) or not isinstance(given, Iterable) else tuple(given)
    for name in names:
        if not isinstance(name, str):
            expected, todo = "names of runs, or patterns such as 'val_*'", f"the runs are {', '.join(map(repr, runs))}"
            raise InputError(argument, expected=expected, got=repr(name), todo=todo)
    return names


def texts_by_text(argument: str, given: object, example: str) -> dict[str, str]:
    """Return a mapping that the caller gave.

    Parameters
    ----------
    argument
        Name of the argument.
    given
        The mapping, or None for an empty one.
    example
        Such a mapping as it is typed.

    Returns
    -------
    dict
        Keys and values as texts.

    Raises
    ------
    InputError
        Where something else was given.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise InputError(argument, expected="a mapping", got=repr(given), todo=f"write {argument}={example}")
    return {str(key): str(value) for key, value in given.items()}


def tables_of_joints(argument: str, given: object) -> dict[int, Mapping[str, Any]]:
    """Return what the caller states of joints.

    Parameters
    ----------
    argument
        Name of the argument.
    given
        Mappings by number of the joint; None for none.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        Where it is no mapping of mappings, or a key is no number.
    """
    if given is None:
        return {}
    expected, todo = "mappings by number of the joint", f'write {argument}={{0: {{"friction": "dahl"}}}}'
    if not isinstance(given, Mapping):
        raise InputError(argument, expected=expected, got=repr(given), todo=todo)
    tables: dict[int, Mapping[str, Any]] = {}
    for joint, table in given.items():
        numbered = isinstance(joint, Integral) or (isinstance(joint, str) and joint.isdecimal())
        if not numbered or not isinstance(table, Mapping):
            raise InputError(argument, expected=expected, got=repr({joint: table}), todo=todo)
        tables[int(joint)] = table
    return tables


def number_of(argument: str, given: object) -> float | None:
    """Return a number that the caller gave.

    Parameters
    ----------
    argument
        Name of the argument.
    given
        Any real number, of numpy as well; None for none.

    Returns
    -------
    float or None

    Raises
    ------
    InputError
        Where something else was given, as a text.
    """
    if given is None:
        return None
    if not isinstance(given, Real) or isinstance(given, bool):
        raise InputError(argument, expected="a number in rad (m of a slide)", got=repr(given), todo="or leave it out")
    return float(given)


def check_workers(workers: object) -> None:
    """Refuse a number of workers that is none.

    Parameters
    ----------
    workers
        What the caller gave.

    Raises
    ------
    InputError
        Where it is no whole number from 1 on.
    """
    if not isinstance(workers, Integral) or isinstance(workers, bool) or workers < 1:
        raise InputError("workers", expected="a whole number from 1 on", got=repr(workers))


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
