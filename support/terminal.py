"""What people see while a command runs and at its end: bars and tables on a terminal, plain lines everywhere else.

The one place that draws on terminals. `Display` shows the state of a computation: on a terminal a bar that is removed
at the end, elsewhere a line at most every `LINE_EVERY_S` seconds, so that a log stays short. `show` prints the summary:
on a terminal with Rich's tables, elsewhere as the plain text that scripts read.
"""

from __future__ import annotations

import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sized
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TextIO, TypeVar

import click

from haptid.support.tables import Table, Told

if TYPE_CHECKING:
    from rich.progress import Progress
    from rich.table import Table as RichTable

T = TypeVar("T")
LINE_EVERY_S = 10.0
"""Shortest interval between two plain lines of the same computation [s]."""
FIRST_LINE_AFTER_S = 2.0
"""Time that a computation takes before a log hears of it [s]."""
LINES_OF_STEPS_EVERY_S = 1.0
"""Shortest interval between two plain lines of different steps [s]."""
LONGEST_INTERVAL_S = 60.0
"""Interval between plain lines of a computation that runs for long [s]."""
SHARE_OF_ELAPSED = 0.1
"""Interval between plain lines over the time that has passed [1], between the two intervals above."""
LEAST_KNOWN_SHARE = 0.02
"""Share of a computation that has to be done before its end is foretold [1]."""
STYLES = {
    "OK": "green", "converged": "green", "identified": "green", "nothing_missing": "green", "named": "cyan",
    "absent": "dim", "fixed": "dim", "prior": "yellow", "partly_named": "yellow", "ambiguous": "yellow",
    "unidentifiable": "yellow", "uncertain": "yellow", "unlisted": "red", "at_bound": "red", "diverged": "red",
    "PROBLEM": "bold red",
}  # fmt: skip
"""Colour of a cell that holds exactly this word; the word itself says the same without colours."""


def is_terminal(stream: TextIO) -> bool:
    """Say whether a stream is a terminal that can move its cursor.

    Parameters
    ----------
    stream
        Standard output or error.

    Returns
    -------
    bool
        False for files, pipes and terminals that call themselves dumb.
    """
    return stream.isatty() and os.environ.get("TERM", "") not in ("dumb", "unknown")


def is_watched(stream: TextIO | None) -> bool:
    """Say whether somebody sees what is written while it is written: on a terminal, or in a notebook.

    Parameters
    ----------
    stream
        Standard error; None where the program has none.

    Returns
    -------
    bool
        False for files, pipes and the log of a service.
    """
    if stream is None:
        return False
    # A notebook's stream is no terminal, and its package need not be installed here.
    return is_terminal(stream) or type(stream).__module__.partition(".")[0] == "ipykernel"


def show(told: Told) -> None:
    """Print lines and tables on stdout.

    Parameters
    ----------
    told
        What the user gets, in order.
    """
    if not is_terminal(sys.stdout):
        for part in told:
            click.echo(str(part))
        return
    from rich.console import Console  # noqa: PLC0415 (a pipe needs no Rich)

    console = Console(file=sys.stdout)
    for part in told:
        if isinstance(part, Table) and part.rows:
            console.print(_draw_table(part))
        else:
            console.print(str(part), markup=False, highlight=False, soft_wrap=True)


def _draw_table(table: Table) -> RichTable:
    from rich.box import SIMPLE_HEAD  # noqa: PLC0415 (a pipe needs no Rich)
    from rich.table import Table as RichTable  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    drawn = RichTable(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    for number, heading in enumerate(table.header):
        numeric = all(_is_number(row[number]) for row in table.rows)
        drawn.add_column(Text(heading), justify="right" if numeric else "left", overflow="fold")
    for row in table.rows:
        drawn.add_row(*[Text(cell, style=STYLES.get(cell, "")) for cell in row])
    return drawn


def _is_number(cell: str) -> bool:
    if cell in ("", "-", "–"):
        return True
    try:
        float(cell.removeprefix("~").partition(" ")[0])
    except ValueError:
        return False
    return True


def clock(seconds: float) -> str:
    """Write a duration as a clock does.

    Parameters
    ----------
    seconds
        Duration [s].

    Returns
    -------
    str

    Examples
    --------
    >>> clock(7.4), clock(83.0), clock(3725.0)
    ('0:07', '1:23', '1:02:05')
    """
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """How far a computation is.

    Parameters
    ----------
    title
        What is being computed, as ``joint 4: sampling``.
    done, total
        Steps that are done, parts of steps included, and steps in all; None where nobody knows their number.
    figures
        Figures so far.
    """

    title: str
    done: float = 0.0
    total: int | None = None
    figures: str = ""

    @property
    def share(self) -> float | None:
        """Share that is done, from 0 to 1; None where nobody knows it."""
        return min(self.done / self.total, 1.0) if self.total else None


@dataclass(slots=True, kw_only=True)
class Display:
    """Show states of a computation on stderr.

    Parameters
    ----------
    quiet
        Whether nothing is shown (--quiet).
    now
        Clock [s].
    """

    quiet: bool = False
    now: Callable[[], float] = time.monotonic
    _began: float | None = None
    _first: tuple[float, float] = (0.0, 0.0)
    _passed: deque[tuple[float, float]] = field(default_factory=deque)
    _shown: State | None = None
    _line_at: float = -float("inf")
    _line: str = ""
    _bar: Any = field(default=None)

    def show(self, title: str, done: float = 0.0, total: int | None = None, figures: str = "") -> None:
        """Show a state; satisfies `support.listener.Progress`.

        Parameters
        ----------
        title, done, total, figures
            As for `State`.
        """
        if self.quiet:
            return
        state, before = State(title=title, done=done, total=total, figures=figures), self._shown
        if self._began is None:
            self._began = self.now()
        if before is None or before.total != total or before.done > done:
            self._first = (self.now(), done)  # a new count: its end is foretold from its own pace
            self._passed = deque([self._first])
        elif before.done < done:
            self._passed.append((self.now(), done))
        self._shown = state
        if is_terminal(sys.stderr):
            self._draw(state)
        else:
            self._write(state, new=before is None or before.title != title)

    def times(self) -> str:
        """Write the time that has passed and, where it can be foretold, the time that is left.

        Returns
        -------
        str
            As ``0:42, about 3:10 left``.
        """
        now = self.now()
        elapsed = now - (now if self._began is None else self._began)
        left = self._time_left(now)
        return clock(elapsed) if left is None else f"{clock(elapsed)}, about {clock(left)} left"

    def _time_left(self, now: float) -> float | None:
        state, (began, first) = self._shown, self._first
        if state is None or not state.total:
            return None
        gained = state.done - first
        if gained < LEAST_KNOWN_SHARE * state.total or state.done >= state.total:
            return None
        rest = state.total - state.done
        # Some work is slower at its end, as starts that none excludes any more: the pace of the later half tells, too,
        # but nothing tells an end that is further off than what has passed.
        return max((now - began) * rest / gained, min(self._time_left_as_lately(now, rest), now - began))

    def _time_left_as_lately(self, now: float, rest: float) -> float:
        """Return the time [s] that ``rest`` takes at the pace of the later half of the present count."""
        half, passed = 0.5 * (now + self._first[0]), self._passed  # a new count in another thread makes a new queue
        while len(passed) > 1 and passed[1][0] <= half:
            passed.popleft()
        since, before = passed[0]
        gained = 0.0 if self._shown is None else self._shown.done - before
        return (now - since) * rest / gained if gained > 0.0 else float("inf")

    def close(self) -> None:
        """Take the bar away, where there is one."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _write(self, state: State, *, new: bool) -> None:
        """Write a plain line, unless the last one is recent: a part that takes a moment gets none."""
        now = self.now()
        elapsed = now - (now if self._began is None else self._began)
        interval = min(max(SHARE_OF_ELAPSED * elapsed, LINE_EVERY_S), LONGEST_INTERVAL_S)
        if elapsed < FIRST_LINE_AFTER_S or now - self._line_at < (LINES_OF_STEPS_EVERY_S if new else interval):
            return
        share = "" if state.share is None else f" {100.0 * state.share:.0f} %,"
        figures = f"; {state.figures}" if state.figures else ""
        line = f"{state.title}:{share} {self.times()}{figures}"
        if line != self._line:
            click.echo(line, err=True)
            self._line_at, self._line = now, line

    def _draw(self, state: State) -> None:
        begins = self._bar is None
        if begins:
            self._bar = self._new_bar()
            self._bar.add_task("")
        (task,) = self._bar.task_ids
        self._bar.update(task, description=state.title, completed=state.share or 0.0,
                         total=None if state.share is None else 1.0, figures=state.figures)  # fmt: skip
        if begins:
            self._bar.start()

    def _new_bar(self) -> Progress:
        from rich.console import Console  # noqa: PLC0415 (a pipe needs no Rich)
        from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn  # noqa: PLC0415
        from rich.text import Text  # noqa: PLC0415

        display = self

        class Share(ProgressColumn):
            """Share that is done, where it is known."""

            def render(self, task: Any) -> Text:
                return Text(f"{task.percentage:3.0f} %" if task.total else "     ")

        class Words(ProgressColumn):
            """Title, times and figures, which are cut where the terminal is narrow."""

            def render(self, task: Any) -> Text:
                figures = f" · {task.fields['figures']}" if task.fields.get("figures") else ""
                return Text(f"{task.description} {display.times()}{figures}", overflow="ellipsis", no_wrap=True)

        columns = (SpinnerColumn(), BarColumn(bar_width=12), Share(), Words())
        return Progress(*columns, console=Console(stderr=True), transient=True, refresh_per_second=4,
                        redirect_stdout=False, redirect_stderr=False)  # fmt: skip


class Count(Generic[T]):
    """Show how many of a number of steps are done: iterable, and a context manager that removes what it shows.

    Parameters
    ----------
    iterable
        Items whose iteration advances the count; None where the caller advances it.
    total
        Number of steps; the length of ``iterable`` where None.
    title
        What is being done.
    quiet
        Whether nothing is shown.
    """

    def __init__(
        self, iterable: Iterable[T] | None = None, *, total: int | None = None, title: str = "", quiet: bool = False
    ) -> None:
        self._items = () if iterable is None else iterable
        self._total = len(iterable) if total is None and isinstance(iterable, Sized) else total
        self._title, self._display = title, Display(quiet=quiet)
        self.n = 0

    def __enter__(self) -> Count[T]:
        """Show that nothing is done yet."""
        self.update(0)
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away."""
        self._display.close()

    def __iter__(self) -> Iterator[T]:
        """Yield the items, and count those that are done."""
        with self:
            for item in self._items:
                yield item
                self.update()

    def update(self, steps: int = 1, figures: str = "") -> None:
        """Count further steps.

        Parameters
        ----------
        steps
            Steps that were done.
        figures
            Figures so far, or the name of what was done.
        """
        self.n += steps
        self._display.show(self._title, self.n, self._total, figures)
