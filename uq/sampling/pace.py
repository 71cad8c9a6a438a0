"""Progress of a sampler whose chains' length follows from τ, which only the chains tell: steps done in, words out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from haptid.identification.workers.workers import Watch
from haptid.support.terminal import clock

TellPace = Callable[[float | None, str], None]
"""Function that is told the share of the steps that is done, None where the end is not known, and words."""
LARGEST_CHANGE_OF_SETTLED_TAU = 0.1
"""Relative change of τ by a chunk up to which the length of the chains is foretold from it [1]."""


@dataclass(slots=True, kw_only=True)
class Pace:
    """How many steps are done, and how many there may be.

    While τ grows from chunk to chunk, nobody knows the end: the range of the time left is told, from what the present τ
    asks for to the longest chains that are allowed, and no share. Once τ has settled, the share is told, which never
    falls.

    Parameters
    ----------
    tell
        Told the share that is done, None while it is not known, and words.
    most
        Most steps that there may be.
    now
        Clock [s].
    """

    tell: TellPace
    most: float
    now: Callable[[], float] = time.monotonic
    _before: float = 0.0
    _read: float = 0.0
    _began: float | None = None
    _expected: float | None = None
    _tau: float = float("nan")
    _settled: bool = False
    _share: float = 0.0
    _figures: str = ""
    _shares: dict[int, float] = field(default_factory=dict)

    def begin_chunk(self, steps: int, ensembles: int) -> Watch:
        """Return what is told how far each ensemble is.

        Parameters
        ----------
        steps
            Steps of the chunk.
        ensembles
            Number of ensembles that are advanced.

        Returns
        -------
        callable
            Takes the number of a task, its share and words.
        """
        self._shares = {}
        if self._began is None and ensembles:
            self._began = self.now()

        def watch(task: int, share: float, _: str) -> None:
            self._shares[task] = share
            self._tell(self._before + steps * sum(self._shares.values()) / ensembles)

        return watch

    def end_chunk(self, steps: int, *, read: bool) -> None:
        """Count the steps of a chunk.

        Parameters
        ----------
        steps
            Steps of the chunk.
        read
            Whether it was read from an earlier command, which says nothing of the pace.
        """
        self._before += steps
        self._read += steps if read else 0.0
        self._tell(self._before)

    def learn(self, left: float, tau: float, effective: float) -> None:
        """Take over what the chains tell after a chunk.

        Parameters
        ----------
        left
            Steps that the chains still need with the present τ.
        tau
            Longest autocorrelation time [steps].
        effective
            Smallest effective sample size.
        """
        # NaN, before any τ is known, is no small change.
        self._settled = abs(tau - self._tau) <= LARGEST_CHANGE_OF_SETTLED_TAU * tau
        self._expected, self._tau = self._before + left, tau
        self._figures = f"τ {tau:.1f}{'' if self._settled else ' and growing'}, ESS {effective:.0f}"

    def _tell(self, done: float) -> None:
        if self._settled and self._expected is not None:
            expected = max(self._expected, done)
            self._share = max(self._share, done / expected)
            self.tell(self._share, f"step {done:.0f} of about {expected:.0f}, {self._figures}")
            return
        words = f"step {done:.0f} of at most {self.most:.0f}{self._word_time_left(done)}"
        self.tell(None, f"{words}, {self._figures}" if self._figures else words)

    def _word_time_left(self, done: float) -> str:
        """Say how long the rest takes at the pace so far; empty where nothing was computed yet."""
        if self._began is None or done <= self._read:
            return ""
        seconds = (self.now() - self._began) / (done - self._read)
        most = f"{clock((self.most - done) * seconds)} left"
        if self._expected is None:
            return f", at most {most}"
        return f", {clock(max(self._expected - done, 0.0) * seconds)} to {most}"
