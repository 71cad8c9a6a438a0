"""Errors with an exit code: one line that says where, what was expected, what came and what to do."""

from __future__ import annotations

LONGEST = 300 - len("error: ")
"""Most characters of an error's message: a command's line has 300 with the ``error: `` before it."""
LEAST_OF_PART = 24
"""Characters of place, expected and got that stay where a long remedy is kept whole."""


class HaptidError(Exception):
    """Base of the errors that end a command with one line on stderr and ``exit_code``."""

    exit_code = 1


class InputError(HaptidError):
    """Bad input (exit code 2), in one line of at most `LONGEST` characters that a terminal can show.

    Parameters
    ----------
    where
        File, line or key at fault.
    expected, got
        Content that the place should have, and the content that it has.
    todo
        Remedy for the user; none where empty.
    """

    exit_code = 2

    def __init__(self, where: str, *, expected: str, got: str, todo: str = "") -> None:
        *parts, remedy = [one_line(part) for part in (where, expected, got, todo)]
        # The room of the four parts is the line's length less that of the words between them.
        room = LONGEST - len(_line("", "", "", "x")) + 1
        # What to type stays whole; the rest is recognised by its ends.
        if len(remedy) <= room - len(parts) * LEAST_OF_PART:
            self.where, self.expected, self.got = _fit_into_room(parts, room - len(remedy))
            self.todo = remedy
        else:
            self.where, self.expected, self.got, self.todo = _fit_into_room([*parts, remedy], room)
        super().__init__(_line(self.where, self.expected, self.got, self.todo))

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild from keywords, so that the error crosses process boundaries."""
        return (_input_error, (self.where, self.expected, self.got, self.todo))


def one_line(text: str) -> str:
    r"""Return ``text`` on one line: white space collapsed, unprintable characters written as escapes.

    A terminal would execute control characters that a file's content may hold.

    Parameters
    ----------
    text
        Any text, of a file or an exception, say.

    Returns
    -------
    str
        Text without line breaks and control characters.

    Examples
    --------
    >>> one_line("joint\n 4 \x1b[2J")
    'joint 4 \\x1b[2J'
    """
    joined = " ".join(text.split())
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode() for c in joined)


def shorten(text: str, most: int) -> str:
    """Replace the middle of a text by … where it is too long.

    Parameters
    ----------
    text
        Any text.
    most
        Most characters of the result.

    Returns
    -------
    str
        ``text``, or its beginning and its end with … between them, together ``most`` characters.

    Examples
    --------
    >>> shorten("position_0_rad_of_the_left_arm", 15)
    'positio…eft_arm'
    """
    if len(text) <= most:
        return text
    head = most // 2
    return text[:head] + "…" + text[len(text) - (most - 1 - head) :]


def _fit_into_room(parts: list[str], room: int) -> list[str]:
    """Shorten the longest parts, each to the same length, until all fit into ``room`` characters."""
    if sum(map(len, parts)) <= room:
        return parts
    least, most = 1, room  # bisection of the largest common length that fits
    while least < most:
        middle = (least + most + 1) // 2
        least, most = (middle, most) if sum(min(len(part), middle) for part in parts) <= room else (least, middle - 1)
    return [shorten(part, least) for part in parts]


def _line(where: str, expected: str, got: str, todo: str) -> str:
    return f"{where}: expected {expected}, got {got}" + (f"; {todo}" if todo else "")


def _input_error(where: str, expected: str, got: str, todo: str) -> InputError:
    return InputError(where, expected=expected, got=got, todo=todo)


class NumericalError(HaptidError):
    """A computation that failed, as where a likelihood is not finite (exit code 1)."""
