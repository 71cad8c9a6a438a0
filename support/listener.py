"""What a long computation tells while it runs: `Listener`, of whom nobody is there by default."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from haptid.support.tables import Told


class Progress(Protocol):
    """Function that is told how far a computation is."""

    def __call__(self, title: str, done: float = 0, total: int | None = None, figures: str = "") -> None:
        """Take the state of a computation.

        Parameters
        ----------
        title
            What is being computed, as ``joint 4: sampling``.
        done, total
            Steps that are done, parts of steps included, and steps in all; None where nobody knows their number.
        figures
            Figures so far, as ``τ 12.3, ESS 800``.
        """


def ignore_progress(title: str, done: float = 0, total: int | None = None, figures: str = "") -> None:
    """Take the state of a computation, and do nothing.

    Parameters
    ----------
    title, done, total, figures
        As for `Progress`.
    """


def _ignore(text: str) -> None:
    """Take a text, and do nothing."""


def _ignore_summary(told: Told) -> None:
    """Take a summary, and do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Listener:
    """Hold the functions that a long computation calls.

    Parameters
    ----------
    progress
        Called with each step.
    note
        Called with each line that a user should see at once, as ``warning: …``; results hold these lines, too.
    finished
        Called with the summary of each part that is finished and written.
    """

    progress: Progress = ignore_progress
    note: Callable[[str], None] = _ignore
    finished: Callable[[Told], None] = _ignore_summary
