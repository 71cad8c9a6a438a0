"""Starts take turns between short steps and long ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from haptid.identification.fit.minima import find_minima
from haptid.identification.problem.options import FitOptions
from haptid.identification.problem.residuals import Problem
from haptid.identification.workers.workers import Enough, Here, Watch
from tests.identification import bench_joint

T = TypeVar("T")


class Noting(Here):
    """Runs tasks in this process and notes the last argument of each."""

    def __init__(self) -> None:
        self.short: list[bool] = []

    def until(
        self, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], more: Enough, *, what: str = "",
        watch: Watch | None = None,
    ) -> list[T]:  # fmt: skip
        self.short = [task[-1] for task in tasks]
        return super().until(function, tasks, more, what=what, watch=watch)


def test_every_other_start_takes_short_steps_and_all_end_at_the_noise():
    fitted = tuple(run for run in bench_joint.runs() if run.use == "fit")
    options = FitOptions(method="gauss_newton", starts=4, agree=4)
    problem, workers = Problem.of(bench_joint.simulator(), fitted, options), Noting()
    minima = find_minima(problem, workers)
    assert workers.short == [True, False, True, False]
    assert minima.basins[0].starts == (0, 1, 2, 3)
    assert minima.basins[0].over_noise < 1.05
