"""Simulators of a joint with effects: readings at a fine inner step, sensitivities at a coarse one.

A minimum lies where Jᵀr = 0. The integration's error in r moves it and stays in what is left over, where it would pass
for missing physics; the same error in J costs a few iterations at most. So only the readings are computed finely.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.simulators.kernel import KernelSimulator
from haptid.identification.simulators.protocol import Trajectory
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations
from haptid.model.equations.output_injection import with_observer
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel

COARSE = 2.5e-3
"""Inner step of sensitivities and first tries [s]."""
SKETCH = 5e-3
"""Inner step of signatures [s], which are differences of simulations at the same step, and of a first sieve."""
_compiled: dict[tuple[str, bool, bool], CompiledKernel] = {}


def compile_kernel(equations: Equations, *, many: bool = False, tangent: bool = True) -> CompiledKernel:
    """Return the kernel of ``equations`` with output injection; made once per process.

    One that runs ``many`` sets at once takes longer to compile, and so does one with sensitivities.
    """
    key = (equations.digest, many, tangent)
    if key not in _compiled:
        _compiled[key] = cached_kernel(with_observer(equations), many=many, tangent=tangent)
    return _compiled[key]


@dataclass(frozen=True, slots=True)
class TwoStep:
    """Runs the equations at one inner step for readings and another for sensitivities and whole sets of parameters."""

    fine: KernelSimulator
    coarse: KernelSimulator

    @property
    def equations(self) -> Equations:
        """The equations with bounds and first guesses."""
        return self.fine.equations

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`."""
        if not sensitivities:
            return self.fine.simulate(theta, run, x0=x0, gain=gain)
        rough = self.coarse.simulate(theta, run, x0=x0, gain=gain, sensitivities=True)
        if self.fine.step >= self.coarse.step or not np.isfinite(rough.y).all():
            return rough
        return replace(rough, y=self.fine.simulate(theta, run, x0=x0, gain=gain).y)

    def simulate_many(self, thetas: Array, run: Run, *, x0: Array | None = None) -> Array:
        """Return outputs (n_sets, n_t, n_y) for parameter sets (n_sets, n_p) at the step of sketches."""
        return self.coarse.with_step(SKETCH).simulate_many(thetas, run, x0=x0)


@dataclass(frozen=True, slots=True)
class Factory:
    """From equations to a simulator: what the search is handed in place of a concrete one.

    Parameters
    ----------
    step
        Inner step of the readings [s], and of sensitivities where it is longer than `COARSE`.
    """

    step: float = COARSE

    def __call__(self, equations: Equations, *, many: bool = False, tangent: bool = True) -> TwoStep:
        """Build the simulator; it runs one set at a time unless asked for more, and has sensitivities unless told."""
        simulator = KernelSimulator(equations, compile_kernel(equations, many=many, tangent=tangent))
        return TwoStep(simulator.with_step(self.step), simulator.with_step(max(self.step, COARSE)))
