"""Workers that tell how far they are: `Workers` and a listening function in, `Watched` out.

A joint is fitted in stages (starts, a fit within wider bounds, refits of a jackknife) of which nobody knows the number
beforehand. Each stage gets `SHARE_OF_STAGE` of what the stages before it left, so that the share of the joint only
grows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from haptid.identification.workers.workers import Enough, Tell, Watch, Workers

T = TypeVar("T")
SHARE_OF_STAGE = 0.5
"""Share that a stage takes of what is left [1]: a joint is fitted in one to five stages of like length."""


@dataclass(slots=True, kw_only=True)
class Watched:
    """Workers whose tasks tell how far they are; satisfies `identification.workers.workers.Workers`.

    Parameters
    ----------
    workers
        Workers that do the work.
    tell
        Told the share of all stages that is done, from 0 to 1, and figures in words.
    """

    workers: Workers
    tell: Tell
    _before: float = field(default=0.0)

    def until(
        self,
        function: Callable[..., T],
        tasks: Sequence[tuple[Any, ...]],
        more: Enough,
        *,
        what: str = "",
        watch: Watch | None = None,
    ) -> list[T]:
        """See `identification.workers.workers.Workers`; without ``what`` nothing is told."""
        if not what:
            return self.workers.until(function, tasks, more, watch=watch)
        stage = _Stage(tell=self.tell, what=what, count=len(tasks), before=self._before)

        def count_results(results: Sequence[T]) -> int:
            needed = more(results)
            stage.count_results(len(results), needed)
            return needed

        results = self.workers.until(function, tasks, count_results, watch=stage.watch)
        self._before = stage.end
        return results


@dataclass(slots=True, kw_only=True)
class _Stage:
    """How far the tasks of one call are."""

    tell: Tell
    what: str
    count: int
    before: float
    done: int = 0
    needed: int = 0
    shares: dict[int, float] = field(default_factory=dict)
    told: float = 0.0

    @property
    def end(self) -> float:
        """Share of all stages where this one ends."""
        return self.before + SHARE_OF_STAGE * (1.0 - self.before)

    def count_results(self, done: int, more: int) -> None:
        self.done, self.needed = done, min(done + max(more, 0), self.count)
        if self.needed > done:
            self._tell("")

    def watch(self, task: int, share: float, figures: str) -> None:
        self.shares[task] = share
        # Tasks ahead of the needed ones run as well; what is told is how far the one is that is waited for.
        if task == self.done:
            self._tell(figures)

    def _tell(self, figures: str) -> None:
        running = sum(self.shares.get(task, 0.0) for task in range(self.done, self.needed))
        share = (self.done + running) / max(self.needed, 1)
        self.told = max(self.told, min(share, 1.0))
        words = f"{self.what} {self.done + 1} of {self.needed}"
        self.tell(self.before + self.told * (self.end - self.before), f"{words}, {figures}" if figures else words)
