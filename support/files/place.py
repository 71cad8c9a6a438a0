"""Place of a value in the user's file, as an error names it: file, key, and line where the line is known."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

KeyPath = tuple[str | int, ...]
_HEADER = re.compile(r"^\s*(\[{1,2})\s*([^\[\]#]+?)\s*\]{1,2}\s*(#.*)?$")
_ASSIGNMENT = re.compile(r"^\s*([\w\"'.-]+(?:\s*\.\s*[\w\"'-]+)*)\s*=")


def join_path(path: KeyPath) -> str:
    """Write a path of keys and indices as one text.

    Parameters
    ----------
    path
        Keys and indices from the top of the file.

    Returns
    -------
    str
        Keys joined by dots, indices in brackets.

    Examples
    --------
    >>> join_path(("links", 1, "inertia", "I11"))
    'links[1].inertia.I11'
    """
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Place of a value in a file.

    Parameters
    ----------
    file
        Name of the file as the user gave it.
    path
        Keys and indices that lead to the value.
    lines
        Line number of every path that has a line of its own (`key_lines`).
    words
        Name of a path in the user's file; differs from `join_path` where the content is converted from another format.
    """

    file: str
    path: KeyPath = ()
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    words: Callable[[KeyPath], str] = join_path

    def at(self, *parts: str | int) -> Place:
        """Go down to the place of a value below this one.

        Parameters
        ----------
        *parts
            Further keys or indices.

        Returns
        -------
        Place
            Place in the same file.
        """
        return replace(self, path=(*self.path, *parts))

    def __str__(self) -> str:
        """``arm.toml, line 7: joints[0].torque_limit``."""
        ends = range(len(self.path), 0, -1)
        line = next((self.lines[self.path[:end]] for end in ends if self.path[:end] in self.lines), None)
        told = f"{self.file}, line {line}" if line else self.file
        words = self.words(self.path)
        return f"{told}: {words}" if words else told


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line of each table and key of a TOML text.

    Parameters
    ----------
    text
        Content of the file, valid TOML.

    Returns
    -------
    dict
        Line number, from 1, by path. Keys within braces on one line have no entry: `Place` falls back on the path
        above them.
    """
    lines: dict[KeyPath, int] = {}
    entries: Counter[KeyPath] = Counter()
    table: KeyPath = ()
    for number, content in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(content)
        if header:
            table = _resolve_path(_keys(header.group(2)), entries, appends=header.group(1) == "[[")
            lines.setdefault(table, number)
            continue
        assignment = _ASSIGNMENT.match(content)
        if assignment:
            lines.setdefault((*table, *_keys(assignment.group(1))), number)
    return lines


def _keys(name: str) -> KeyPath:
    return tuple(part.strip().strip("\"'") for part in name.split("."))


def _resolve_path(keys: KeyPath, entries: Counter[KeyPath], *, appends: bool) -> KeyPath:
    """Return the path of a header, in which a list of tables stands with the number of its last entry so far."""
    path: KeyPath = ()
    for place, key in enumerate(keys):
        path = (*path, key)
        if appends and place == len(keys) - 1:
            entries[path] += 1
        if entries[path]:
            path = (*path, entries[path] - 1)
    return path
