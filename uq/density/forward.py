"""Simulated positions for many parameter sets: through the compiled kernel together, or any simulator one by one.

Parameter sets and a run in, positions [rad] out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from haptid.identification.simulators.inverse_dynamics import TorqueSimulator
from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Simulator
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.kernel.pieces import inner_steps
from haptid.uq.thresholds import THRESHOLDS


class Forward(Protocol):
    """Simulates one run for many parameter sets."""

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """Simulate ``run`` for every parameter set.

        Parameters
        ----------
        thetas
            Parameters in the order of ``equations.parameters``, shape (n_sets, n_p).
        run
            The run.
        x0
            Initial state, shape (n_x,).

        Returns
        -------
        ndarray, shape (n_sets, n_t)
            Positions [rad], NaN where a simulation diverged.
        """

    def inner_steps(self, run: Run) -> int:
        """Count the inner steps of a simulation, the measure of its cost.

        Parameters
        ----------
        run
            The run.

        Returns
        -------
        int
            One an interval between rows, where the inner step is not known.
        """

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:
        """Return the positions of a fine inner step minus those of this one.

        Parameters
        ----------
        thetas
            Parameters in the order of ``equations.parameters``, shape (n_sets, n_p).
        run
            The run.
        x0
            Initial state, shape (n_x,).

        Returns
        -------
        ndarray, shape (n_sets, n_t)
            Difference [rad]; 0 where the inner step cannot be chosen.
        """


@lru_cache(maxsize=64)
def kernel_of(equations: Equations) -> KernelSimulator:
    """Return the in-process simulator of ``equations``, built once per process.

    Parameters
    ----------
    equations
        Equations without observer.

    Returns
    -------
    KernelSimulator
        With the default inner step.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    return KernelSimulator.of(equations)


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelForward:
    """Simulation by the compiled kernel; it crosses processes as equations and is compiled there.

    Parameters
    ----------
    equations
        Equations to compile.
    step
        Inner step [s].
    threads
        Threads among which the parameter sets are shared.
    correction
        Inner step of the simulation to which this one is compared [s].
    """

    equations: Equations
    step: float
    threads: int = 1
    correction: float = THRESHOLDS.inner_step_of_correction_s

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        return self._with_step(thetas, run, x0, self.step)

    def inner_steps(self, run: Run) -> int:
        """See `Forward`."""
        return int(inner_steps(run.t, self.step).sum())

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`; 0 where ``step`` is at most ``correction``."""
        if self.step <= self.correction:
            return np.zeros((len(thetas), run.t.size))
        return self._with_step(thetas, run, x0, self.correction) - self(thetas, run, x0)

    def simulator(self) -> KernelSimulator:
        """Put the same kernel behind the `Simulator` protocol.

        Returns
        -------
        KernelSimulator
            Simulator with the same equations and inner step.
        """
        return kernel_of(self.equations).with_step(self.step)

    def _with_step(self, thetas: Array, run: Run, x0: Array, step: float) -> Array:
        simulator = kernel_of(self.equations).with_step(step)
        return np.asarray(simulator.simulate_many(thetas, run, x0=x0, threads=self.threads)[:, :, 0])


class OwnStep:
    """Half of a `Forward` whose inner step cannot be chosen."""

    __slots__ = ()

    def inner_steps(self, run: Run) -> int:
        """See `Forward`."""
        return run.t.size - 1

    def shortfall(self, thetas: Array, run: Run, x0: Array) -> Array:  # noqa: ARG002 # the protocol's arguments
        """See `Forward`; zeros, because the inner step is taken as it is."""
        return np.zeros((len(thetas), run.t.size))


@dataclass(frozen=True, slots=True, kw_only=True)
class EachForward(OwnStep):
    """Simulation through any `Simulator` (an FMU, say), one parameter set after the other.

    Parameters
    ----------
    simulator
        Simulator of the equations.
    """

    simulator: Simulator

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`."""
        return np.array([self.simulator.simulate(theta, run, x0=x0).y[:, 0] for theta in thetas])


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueForward(OwnStep):
    """Torque of a joint along its measured motion, by the compiled torque equation for all parameter sets together.

    Parameters
    ----------
    equations
        Torque equation, as `identification.simulators.inverse_dynamics.torque_equations` returns it.
    """

    equations: Equations

    def __call__(self, thetas: Array, run: Run, x0: Array) -> Array:
        """See `Forward`; the run is one of `torque_run`, and the result a torque [N m] or force [N]."""
        return self.simulator().simulate_many(np.asarray(thetas), run, x0=x0)[:, :, 0]

    def simulator(self) -> TorqueSimulator:
        """Return the compiled torque equation, built once per process.

        Returns
        -------
        TorqueSimulator
            Simulator with sensitivities.
        """
        return torque_of(self.equations)


@lru_cache(maxsize=64)
def torque_of(equations: Equations) -> TorqueSimulator:
    """Return the simulator of a torque equation, built once per process.

    Parameters
    ----------
    equations
        Torque equation.

    Returns
    -------
    TorqueSimulator
        With the default inner step.

    Raises
    ------
    NumericalError
        Where the compiler is missing or fails.
    """
    return TorqueSimulator.of_torque(equations)
