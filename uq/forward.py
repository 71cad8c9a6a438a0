"""Simulated positions for many parameter sets: by the compiled kernel in lanes, or one by one through any simulator."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from identification.kernel_simulator import KernelSimulator
from identification.simulator import Simulator
from measurement.run import Array, Run
from model.equations import Equations
from model.kernel.compiled import CompiledKernel
from model.observer import with_observer

STEPS = (5e-3, 2.5e-3, 1.25e-3, 1e-3, 5e-4)
SHARE = 0.1
"""Share of σ/√N that the solver's error may reach."""


class Forward(Protocol):
    """Simulates one run for many parameter sets."""

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """Positions (n_sets, n_t) for parameters (n_sets, n_p) from the initial state (n_x,); NaN where one blew up."""


@lru_cache(maxsize=64)
def kernel_of(equations: Equations) -> KernelSimulator:
    """Return the in-process simulator of ``equations``, made once per process."""
    return KernelSimulator.of(equations)


@lru_cache(maxsize=64)
def coarse(equations: Equations, step: float) -> KernelSimulator:
    """Return the in-process simulator with inner step ``step`` [s], as `longest_step` found it to suffice."""
    plain = CompiledKernel.of(equations, step=step)
    return KernelSimulator(equations, plain, CompiledKernel.of(with_observer(equations), step=step))


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelForward:
    """The compiled kernel with inner step ``step`` [s]; crosses processes as equations, compiled there."""

    equations: Equations
    step: float
    threads: int = 1

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        kernel = kernel_of(self.equations).plain
        starts = np.broadcast_to(x0, (thetas.shape[0], x0.size))
        linear = run.hold == "linear"
        y = kernel.simulate_many(run.t, run.u, thetas, starts, linear=linear, step=self.step, threads=self.threads)
        return np.asarray(y[:, :, 0])


@dataclass(frozen=True, slots=True, kw_only=True)
class EachForward:
    """Any simulator, one parameter set after the other."""

    simulator: Simulator

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        return np.array([self.simulator.simulate(theta, run, x0=x0).y[:, 0] for theta in thetas])


def longest_step(equations: Equations, theta: Array, runs: list[tuple[Run, Array]]) -> float:
    """Longest inner step whose RMS error at ``theta`` stays below a tenth of σ/√N, N the rows of all ``runs``.

    At that size no parameter can move by more than a tenth of its standard deviation. The error is the difference to
    a step of 50 µs.
    """
    rows = sum(run.t.size for run, _ in runs)
    kernel = kernel_of(equations).plain
    fine = [_at(kernel, theta, run, x0, 5e-5) for run, x0 in runs]
    for step in STEPS:
        errors = [
            float(np.sqrt(np.mean((_at(kernel, theta, run, x0, step) - y) ** 2))) / float(run.sensor_std[0])
            for (run, x0), y in zip(runs, fine, strict=True)
        ]
        if max(errors) <= SHARE / np.sqrt(rows):
            return step
    return STEPS[-1]


def _at(kernel: CompiledKernel, theta: Array, run: Run, x0: Array, step: float) -> Array:
    return np.asarray(kernel.simulate(run.t, run.u, theta, x0, linear=run.hold == "linear", step=step)[:, 0])
