"""Change one threshold for a while, and note which ones are read."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any

from haptid.support.errors import InputError
from studies.thresholds.values import ROOMS, Value, room_values


@contextmanager
def change_threshold(room: str, name: str, value: Value) -> Iterator[None]:
    """Give a threshold another value for all readers of its room, and its own again at the end.

    Parameters
    ----------
    room, name
        As in `values.Threshold`.
    value
        New value.

    Raises
    ------
    InputError
        Where the room has no such threshold.
    """
    values = room_values(room)
    if name not in {f.name for f in fields(values)}:
        raise InputError(room, expected="the name of one of its thresholds", got=repr(name))
    before = getattr(values, name)
    object.__setattr__(values, name, value)  # frozen: no reader changes it, this study alone does
    try:
        yield
    finally:
        object.__setattr__(values, name, before)


@contextmanager
def noted_reads() -> Iterator[set[str]]:
    """Note every threshold that is read within the block.

    Yields
    ------
    set of str
        Keys ``<room>.<name>`` of the thresholds that have been read so far; it grows.
    """
    rooms = {id(room_values(room)): room for room in ROOMS}
    owners = {type(room_values(room)): {f.name for f in fields(room_values(room))} for room in ROOMS}
    reads: set[str] = set()

    def noting(own: set[str]) -> Any:
        def read(values: object, name: str) -> object:
            if name in own:
                reads.add(f"{rooms[id(values)]}.{name}")
            return object.__getattribute__(values, name)

        return read

    for owner, own in owners.items():
        owner.__getattribute__ = noting(own)  # the class reads as before, and notes it
    try:
        yield reads
    finally:
        for owner in owners:
            del owner.__getattribute__


def loaded_readers() -> list[str]:
    """List the loaded modules that hold thresholds and are none of those that define them.

    Returns
    -------
    list of str
        Names of the modules in alphabetical order.
    """
    known = {id(room_values(room)) for room in ROOMS} | {id(room_values("discrepancy.fit"))}
    return sorted(
        name
        for name, module in tuple(sys.modules.items())
        if name.startswith("haptid.")
        and ".thresholds" not in name
        and any(id(held) in known or type(held).__name__ == "Thresholds" for held in vars(module).values())
    )
