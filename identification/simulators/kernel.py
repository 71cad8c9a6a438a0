"""The in-process simulator: `Equations` in, `KernelSimulator` out, which runs the compiled kernel as a `Simulator`.

It is the independent check of the FMU.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.simulators.protocol import (
    Trajectory,
    as_recorded,
    initial_state,
    observer_hold,
    observer_inputs,
)
from haptid.measurement.signals.averaging import average_rows
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.thresholds import THRESHOLDS


@dataclass(frozen=True, slots=True)
class KernelSimulator:
    """Simulator that runs the compiled equations in this process; satisfies `Simulator`.

    Parameters
    ----------
    equations
        The equations without observer.
    kernel
        The equations compiled with the observer; with gain 0 it gives the same bits as the equations without observer.
    step
        Longest inner step of the integration [s].
    """

    equations: Equations
    kernel: CompiledKernel
    step: float = THRESHOLDS.inner_step_s

    @classmethod
    def of(cls, equations: Equations) -> KernelSimulator:
        """Compile equations with the observer.

        Parameters
        ----------
        equations
            The equations without observer.

        Returns
        -------
        KernelSimulator
            With the default inner step.

        Raises
        ------
        NumericalError
            Where the compiler is missing or fails.
        """
        return cls(equations, cached_kernel(with_observer(equations)))

    def with_step(self, step: float) -> KernelSimulator:
        """Return the same kernel with another inner step.

        Parameters
        ----------
        step
            Longest inner step [s].

        Returns
        -------
        KernelSimulator
        """
        return replace(self, step=step)

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`."""
        start = initial_state(self.equations, run) if x0 is None else x0
        inputs, linear = observer_inputs(run, gain), observer_hold(run)
        if not sensitivities:
            y = self.kernel.simulate(run.t, inputs, theta, start, linear=linear, step=self.step)
            return as_recorded(run, Trajectory(t=run.t, y=y))
        y, dy = self.kernel.simulate_tangent(run.t, inputs, theta, start, linear=linear, step=self.step)
        n, starts = len(self.equations.parameters), self.kernel.kernel.starts
        by_start = dy[..., n:]
        if len(starts) < start.size:
            by_start = np.full((*y.shape, start.size), np.nan)
            by_start[..., starts] = dy[..., n:]
        return as_recorded(run, Trajectory(t=run.t, y=y, dy_dtheta=dy[..., :n], dy_dx0=by_start))

    def onward(self, theta: Array, run: Run, rows: slice, x: Array) -> tuple[Array, Array]:
        """Simulate some rows of a run, freely, from a state at the first of them.

        Parameters
        ----------
        theta
            Parameters, shape (n_p,).
        run
            Run whose torques drive the simulation.
        rows
            Consecutive rows that are simulated.
        x
            State at the first of these rows, shape (n_x,).

        Returns
        -------
        y : ndarray, shape (n_rows, n_y)
            Outputs [rad] as they are, before any average over rows; bit by bit those of a simulation of the whole run.
        last : ndarray, shape (n_x,)
            State at the last row.
        """
        inputs, linear = observer_inputs(run, 0.0, rows), observer_hold(run)
        return self.kernel.simulate_through(run.t[rows], inputs, theta, x, linear=linear, step=self.step)

    def simulate_many(
        self, thetas: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, threads: int = 1
    ) -> Array:
        """Simulate a run for many parameter sets.

        Parameters
        ----------
        thetas
            Parameter sets, shape (n_sets, n_p).
        run
            Run whose torques drive the simulation.
        x0
            Initial state of all sets, shape (n_x,), or of each, shape (n_sets, n_x); `initial_state` where None.
        gain
            Observer gain L [1/s]; 0 simulates freely.
        threads
            Number of threads that share the sets.

        Returns
        -------
        ndarray, shape (n_sets, n_t, n_y)
            Outputs [rad].
        """
        start = initial_state(self.equations, run) if x0 is None else np.asarray(x0)
        starts = np.broadcast_to(start, (thetas.shape[0], len(self.equations.states)))
        inputs, linear = observer_inputs(run, gain), observer_hold(run)
        made = self.kernel.simulate_many(run.t, inputs, thetas, starts, linear=linear, threads=threads, step=self.step)
        return average_rows(made.swapaxes(0, 1), run.averaged_rows).swapaxes(0, 1)
