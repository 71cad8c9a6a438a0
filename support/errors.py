"""Errors with an exit code: one line that says where, what was expected, what came and what to do."""

from __future__ import annotations


class HaptidError(Exception):
    """Base of the errors that end a command with one line on stderr and ``exit_code``."""

    exit_code = 1


class InputError(HaptidError):
    """Bad input (exit code 2).

    Parameters
    ----------
    where
        File, line or key at fault.
    expected, got
        What should have stood there, and what did.
    todo
        What the user can do about it.
    """

    exit_code = 2

    def __init__(self, where: str, *, expected: str, got: str, todo: str = "") -> None:
        self.where, self.expected, self.got, self.todo = where, expected, got, todo
        super().__init__(f"{where}: expected {expected}, got {got}" + (f"; {todo}" if todo else ""))

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild from keywords, so that the error crosses process boundaries."""
        return (_input_error, (self.where, self.expected, self.got, self.todo))


def _input_error(where: str, expected: str, got: str, todo: str) -> InputError:
    return InputError(where, expected=expected, got=got, todo=todo)


class NumericalError(HaptidError):
    """A computation failed and said so (exit code 1)."""
