"""What every contestant's process does: read the statement, fit from each start within the budget, write what came out.

Runs in the contestants' own environments, so it needs only NumPy.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import platform
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

Array = Any


class TimeUp(Exception):  # noqa: N818 - no error: the budget is spent
    """The wall-clock budget of a start is spent."""


@dataclass(frozen=True)
class Statement:
    """The problem as a contestant sees it: the lists of ``statement.json`` as arrays, and the folder to work in."""

    folder: Path
    names: tuple[str, ...]
    lower: Array
    upper: Array
    starts: Array
    noise: float
    cosines: tuple[tuple[float, float], ...]
    t: Array
    u: Array
    y: Array
    budget: float
    variant: str

    @classmethod
    def read(cls, path: Path, *, budget: float, count: int, variant: str) -> Statement:
        """Read ``statement.json`` and keep the first ``count`` starts."""
        told = json.loads(path.read_text(encoding="utf-8"))
        arrays = {k: np.array(told[k]) for k in ("lower", "upper", "t", "u", "y")}
        return cls(
            folder=path.parent,
            names=tuple(told["names"]),
            starts=np.array(told["starts"])[:count],
            noise=told["noise"],
            cosines=tuple((a, w) for a, w in told["cosines"]),
            budget=budget,
            variant=variant,
            **arrays,
        )


@dataclass
class Best:
    """The best parameters of a start so far, and the number of simulations; a start cut short hands these in."""

    theta: Array = None
    cost: float = float("inf")
    simulations: int = 0
    note: str = ""

    def seen(self, theta: Array, cost: float) -> float:
        """Note a simulation and return ``cost``."""
        self.simulations += 1
        if cost < self.cost:
            self.theta, self.cost = np.array(theta, dtype=float), float(cost)
        return cost


Fit = Callable[[Array, Best], None]
"""Fits from a start (9,) and leaves the result in the second argument."""


def _ring(_signal: int, _frame: Any) -> None:
    raise TimeUp


def _one(fit: Fit, start: Array, budget: float) -> dict[str, Any]:
    best = Best()
    signal.setitimer(signal.ITIMER_REAL, budget)
    began, used = time.perf_counter(), time.process_time()
    try:
        fit(start, best)
    except TimeUp:
        best.note = "budget spent"
    except Exception as error:  # whatever a contestant raises counts as a miss, and is told
        best.note = f"{type(error).__name__}: {error}"[:200]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    seconds, cpu = time.perf_counter() - began, time.process_time() - used
    theta = None if best.theta is None else best.theta.tolist()
    return {"theta": theta, "seconds": seconds, "cpu_seconds": cpu, "simulations": best.simulations, "note": best.note}


def compete(prepare: Callable[[Statement], Fit], packages: tuple[str, ...]) -> None:
    """Run a contestant: ``prepare`` (timed apart) returns its fit; results go to the file named on the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("statement", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--budget", type=float, default=60.0)
    parser.add_argument("--count", type=int, default=4)
    parser.add_argument("--variant", default="", help="what a contestant with several ways goes")
    given = parser.parse_args()
    signal.signal(signal.SIGALRM, _ring)
    statement = Statement.read(given.statement, budget=given.budget, count=given.count, variant=given.variant)
    began = time.perf_counter()
    fit = prepare(statement)
    prepared = time.perf_counter() - began
    starts = []
    for start in statement.starts:
        starts.append(_one(fit, start, given.budget))
        result = {
            "software": {"python": platform.python_version(), **{p: importlib.metadata.version(p) for p in packages}},
            "preparation_s": prepared,
            "starts": starts,
        }
        given.out.write_text(json.dumps(result), encoding="utf-8")
