"""Drawings of an identification's configurations: finished steps in, `Section`s out, drawn while others are fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import AbstractContextManager
from types import TracebackType

from haptid.identification.sequence.step import Step
from haptid.identification.simulators.protocol import Simulator
from haptid.model.equations.equations import Equations
from haptid.report.common.page import Section
from haptid.report.identification.configuration_sections import draw_configuration
from haptid.support.listener import Listener
from haptid.support.processes.pool import Pool
from haptid.support.processes.threads import single_threaded

Sections = tuple[Section, ...]


class Drawings(AbstractContextManager["Drawings"]):
    """Draws configurations in processes that give way to the fits, or in this process at the end.

    Parameters
    ----------
    workers
        Most processes; 1 starts none. The first starts with the first configuration, another one only where a
        configuration would wait.
    """

    def __init__(self, workers: int = 1) -> None:
        self._pool = Pool(workers, gentle=True) if workers > 1 else None
        self._begun: dict[str, Future[Sections]] = {}

    def begin(self, step: Step, simulator_of: Callable[[Equations], Simulator]) -> None:
        """Begin to draw a configuration; nothing happens where this process draws.

        Parameters
        ----------
        step
            Configuration with its fit.
        simulator_of
            Picklable function from equations to a simulator.
        """
        if self._pool is not None:
            future = self._pool.submit(single_threaded, draw_configuration, step, simulator_of)
            self._begun[step.configuration.anchor] = future

    def sections(
        self, steps: Sequence[Step], simulator_of: Callable[[Equations], Simulator], listener: Listener
    ) -> list[Sections]:
        """Return the sections of all configurations, and draw those that were not begun.

        Parameters
        ----------
        steps
            Configurations with their fits.
        simulator_of
            As `begin` takes it.
        listener
            Told of each configuration, and of each part of one that this process draws.

        Returns
        -------
        list of tuple of Section
            As `draw_configuration` returns them, one tuple a configuration.
        """
        drawn = []
        for number, step in enumerate(steps):
            title = f"report: {step.configuration.name}"

            def begins(part: str, share: float, title: str = title, number: int = number) -> None:
                listener.progress(title, number + share, len(steps), part)

            listener.progress(title, number, len(steps))
            begun = self._begun.get(step.configuration.anchor)
            drawn.append(draw_configuration(step, simulator_of, begins) if begun is None else begun.result())
        return drawn

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes, in the middle of a drawing after an error or Ctrl-C."""
        if self._pool is not None:
            self._pool.__exit__(kind, error, trace)
