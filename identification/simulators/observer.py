"""Simulation pulled towards the measured position, as a simulator of its own: the last level of the fit keeps a gain.

A run in which small errors of torque grow faster than the motion forgets them cannot be simulated freely: what is left
is then not noise but that growth. With a stated gain L the observer q̇ = v + 2L(y − q), v̇ = f + L²(y − q) forgets
within 1/L, and its residual y − q is the error of the torque seen through 1/(s + L)²: an error δτ that lasts longer
than 1/L leaves δτ/(M·L²).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from haptid.identification.simulators.protocol import Simulator, Trajectory, at_step
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True)
class Observed:
    """A simulator whose observer gain never falls below ``least`` [1/s]; it satisfies `Simulator` itself."""

    base: Simulator
    least: float

    @property
    def equations(self) -> Equations:
        """The equations without observer."""
        return self.base.equations

    def with_step(self, step: float) -> Observed:
        """Return the same with inner steps of at most ``step`` [s]."""
        return replace(self, base=at_step(self.base, step))

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`; ``gain`` is raised to the least one."""
        return self.base.simulate(theta, run, x0=x0, gain=max(gain, self.least), sensitivities=sensitivities)
