"""The in-process simulator: the compiled kernel behind the `Simulator` protocol, the independent check of the FMU."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.simulators.protocol import Trajectory, initial_state, observer_hold, observer_inputs
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.kernel.generate import DEFAULT_STEP


@dataclass(frozen=True, slots=True)
class KernelSimulator:
    """Runs the equations in process with inner steps of at most ``step`` [s].

    ``kernel`` is compiled with the observer: its gain 0 gives the bits of the equations without it. `simulate_many`
    takes many parameter sets at once.
    """

    equations: Equations
    kernel: CompiledKernel
    step: float = DEFAULT_STEP

    @classmethod
    def of(cls, equations: Equations) -> KernelSimulator:
        """Compile ``equations`` with the observer."""
        return cls(equations, CompiledKernel.of(with_observer(equations)))

    def with_step(self, step: float) -> KernelSimulator:
        """Return the same kernel with inner steps of at most ``step`` [s]."""
        return replace(self, step=step)

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`."""
        start = initial_state(self.equations, run) if x0 is None else x0
        inputs, linear = observer_inputs(run, gain), observer_hold(run)
        if not sensitivities:
            y = self.kernel.simulate(run.t, inputs, theta, start, linear=linear, step=self.step)
            return Trajectory(t=run.t, y=y)
        y, dy = self.kernel.simulate_tangent(run.t, inputs, theta, start, linear=linear, step=self.step)
        n = len(self.equations.parameters)
        return Trajectory(t=run.t, y=y, dy_dtheta=dy[..., :n], dy_dx0=dy[..., n:])

    def onward(self, theta: Array, run: Run, rows: slice, x: Array) -> tuple[Array, Array]:
        """Return the outputs (n_rows, n_y) of some ``rows`` of a run from the state x at the first, and the last state.

        They have the bits of the whole run's.
        """
        inputs, linear = observer_inputs(run, 0.0)[rows], observer_hold(run)
        return self.kernel.simulate_through(run.t[rows], inputs, theta, x, linear=linear, step=self.step)

    def simulate_many(self, thetas: Array, run: Run, *, x0: Array | None = None, threads: int = 1) -> Array:
        """Return outputs (n_sets, n_t, n_y) for parameter sets (n_sets, n_p); x0 is (n_x,) or (n_sets, n_x)."""
        start = initial_state(self.equations, run) if x0 is None else np.asarray(x0)
        starts = np.broadcast_to(start, (thetas.shape[0], len(self.equations.states)))
        inputs, linear = observer_inputs(run, 0.0), observer_hold(run)
        return self.kernel.simulate_many(run.t, inputs, thetas, starts, linear=linear, threads=threads, step=self.step)
