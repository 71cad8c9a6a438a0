"""Simulated positions for many parameter sets: by the compiled kernel in lanes, or one by one through any simulator."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations

FINE = 2.5e-4
"""Inner step [s] of the simulation against which a coarser one is corrected."""


class Forward(Protocol):
    """Simulates one run for many parameter sets."""

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """Positions (n_sets, n_t) for parameters (n_sets, n_p) from the initial state (n_x,); NaN where one blew up."""

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:
        """Return what a fine inner step would add to them, same shape; 0 where the simulator has its own step."""


@lru_cache(maxsize=64)
def kernel_of(equations: Equations) -> KernelSimulator:
    """Return the in-process simulator of ``equations``, made once per process."""
    return KernelSimulator.of(equations)


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelForward:
    """The compiled kernel with inner step ``step`` [s]; crosses processes as equations, compiled there."""

    equations: Equations
    step: float
    threads: int = 1

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        return self._with_step(thetas, run, x0, self.step)

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        if self.step <= FINE:
            return np.zeros((len(thetas), run.t.size))
        return self._with_step(thetas, run, x0, FINE) - self(thetas, run, x0)

    def simulator(self) -> KernelSimulator:
        """Return the same kernel with the same inner step behind the `Simulator` protocol."""
        return kernel_of(self.equations).with_step(self.step)

    def _with_step(self, thetas: Array, run: Run, x0: Array, step: float) -> Array:
        simulator = kernel_of(self.equations).with_step(step)
        return np.asarray(simulator.simulate_many(thetas, run, x0=x0, threads=self.threads)[:, :, 0])


@dataclass(frozen=True, slots=True, kw_only=True)
class EachForward:
    """Any simulator, one parameter set after the other."""

    simulator: Simulator

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        return np.array([self.simulator.simulate(theta, run, x0=x0).y[:, 0] for theta in thetas])

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:  # noqa: ARG002 # the protocol's arguments
        """See `Forward`."""
        return np.zeros((len(thetas), run.t.size))
