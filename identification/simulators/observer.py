"""Simulation through an observer: `Simulator` in, `Observed` out, whose gain never falls below a stated one.

A run in which small errors of torque grow faster than the motion forgets them cannot be simulated freely: the residual
would show that growth instead of the noise. With a stated gain L the observer

    q̇ = v + 2L(y − q),   v̇ = f + L²(y − q)

forgets an error within 1/L, and its residual y − q is the error of the torque filtered by 1/(s + L)²: an error δτ that
lasts longer than 1/L gives the residual δτ/(M·L²).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from haptid.identification.simulators.protocol import Simulator, Trajectory, at_step
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations


@dataclass(frozen=True, slots=True)
class Observed:
    """Simulator whose observer gain never falls below a stated one; satisfies `Simulator`.

    Parameters
    ----------
    base
        Simulator of the same equations.
    least
        Smallest observer gain L [1/s].
    """

    base: Simulator
    least: float

    @property
    def equations(self) -> Equations:
        """The equations without observer."""
        return self.base.equations

    def with_step(self, step: float) -> Observed:
        """Return the same simulator with another inner step, where its base has one.

        Parameters
        ----------
        step
            Longest inner step [s].

        Returns
        -------
        Observed
        """
        return replace(self, base=at_step(self.base, step))

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`; a gain below ``least`` is raised to it."""
        return self.base.simulate(theta, run, x0=x0, gain=max(gain, self.least), sensitivities=sensitivities)
