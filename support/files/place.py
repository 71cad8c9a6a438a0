"""Where a value stands in the user's file, as an error names it: file, line where it can be told, and key."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

KeyPath = tuple[str | int, ...]
_HEADER = re.compile(r"^\s*(\[{1,2})\s*([^\[\]#]+?)\s*\]{1,2}\s*(#.*)?$")
_ASSIGNMENT = re.compile(r"^\s*([\w\"'.-]+(?:\s*\.\s*[\w\"'-]+)*)\s*=")


def dotted(path: KeyPath) -> str:
    """Return a path of keys and indices in words.

    Examples
    --------
    >>> dotted(("links", 1, "inertia", "I11"))
    'links[1].inertia.I11'
    """
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).lstrip(".")


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A value of a file.

    Parameters
    ----------
    file
        As the user named it.
    path
        Keys and indices that lead to the value.
    lines
        Line of each path that begins one (`key_lines`).
    words
        What a path is called in the user's file; its keys, joined by dots, unless another file was converted.
    """

    file: str
    path: KeyPath = ()
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    words: Callable[[KeyPath], str] = dotted

    def at(self, *parts: str | int) -> Place:
        """Return the place of what stands below."""
        return replace(self, path=(*self.path, *parts))

    def __str__(self) -> str:
        """``arm.toml, line 7: joints[0].torque_limit``."""
        ends = range(len(self.path), 0, -1)
        line = next((self.lines[self.path[:end]] for end in ends if self.path[:end] in self.lines), None)
        told = f"{self.file}, line {line}" if line else self.file
        words = self.words(self.path)
        return f"{told}: {words}" if words else told


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line of each table and key of a TOML text; keys within one line's braces have the line's."""
    lines: dict[KeyPath, int] = {}
    entries: Counter[KeyPath] = Counter()
    table: KeyPath = ()
    for number, content in enumerate(text.splitlines(), start=1):
        header = _HEADER.match(content)
        if header:
            table = _resolved(_keys(header.group(2)), entries, appends=header.group(1) == "[[")
            lines.setdefault(table, number)
            continue
        assignment = _ASSIGNMENT.match(content)
        if assignment:
            lines.setdefault((*table, *_keys(assignment.group(1))), number)
    return lines


def _keys(name: str) -> KeyPath:
    return tuple(part.strip().strip("\"'") for part in name.split("."))


def _resolved(keys: KeyPath, entries: Counter[KeyPath], *, appends: bool) -> KeyPath:
    """Return the path of a header, in which a list of tables stands with the number of its last entry so far."""
    path: KeyPath = ()
    for place, key in enumerate(keys):
        path = (*path, key)
        if appends and place == len(keys) - 1:
            entries[path] += 1
        if entries[path]:
            path = (*path, entries[path] - 1)
    return path
