"""Runs recorded under position control: the measured motion goes in, the torque comes out and is scored.

A simulation from the torque of a position controller drifts: that torque holds the joint where it is told to be. The
same equation is therefore read the other way round, with the states of the friction law driven by the measured speed:

    τ = (M·q̈ + g_c·cos q + g_s·sin q + Ks·(q − epos) + friction)/Kp
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from haptid.identification.simulators.protocol import Trajectory
from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.signals.smoothing import smooth
from haptid.measurement.values.run import Array, Run
from haptid.model.effects.effect import q, v
from haptid.model.equations.equations import Equations, Input, Output
from haptid.model.friction.registry import law_named
from haptid.model.joint.locked_joint import joint_equations
from haptid.model.kernel.compiled import CompiledKernel

WIDTH_S = 0.02
"""Standard deviation of the Gaussian that smooths the measured motion [s]."""


def torque_equations(equations: Equations) -> Equations:
    """Return the equation of one joint read from motion to torque: inputs q, v, a; states of friction; output τ."""
    law = law_named(equations.friction[0])
    base = joint_equations(
        equations.joints[0], parameters=equations.parameters, prismatic=_slides(equations), friction=law.id
    )
    p = {x.id: x.symbol for x in equations.parameters}
    a = Input(id="a", unit="rad/s^2", description="measured acceleration")
    acceleration = base.rhs[1]
    tau = base.inputs[0].symbol
    sizes = law.nominal({x.id: x.initial for x in equations.parameters})
    # Kp·τ stands alone in M·v̇ = Kp·τ − load: solving the equation for τ needs no more than its value at τ = 0.
    load = -(acceleration.subs(tau, 0) * p["inertia"]).expand()
    return replace(
        base,
        name=f"{base.name}_torque",
        title=f"{base.title}, from measured motion to torque",
        joints=(),
        states=tuple(replace(s, nominal=n) for s, n in zip(base.states[2:], sizes, strict=True)),
        inputs=(
            Input(id=q.name, unit=base.states[0].unit, description="measured position"),
            Input(id=v.name, unit=base.states[1].unit, description="measured speed"),
            a,
        ),
        outputs=(
            Output(
                id="torque",
                unit=base.inputs[0].unit,
                description="torque that the measured motion needs",
                expression=(p["inertia"] * a.symbol + load) / p["Kp"],
            ),
        ),
        rhs=base.rhs[2:],
        rates=base.rates[2:],
        definitions=(),
    )


def _slides(equations: Equations) -> bool:
    return equations.states[0].unit == "m"


def torque_run(run: Run) -> Run:
    """Return the run with position as input and torque as what is measured, with the torque's own white noise."""
    step = estimate_resolution(run.u[:, 0])
    return run.but(
        u=run.y,
        y=run.u,
        v=None,
        noise=np.array([estimate_noise(run.t, run.u[:, 0], step)]),
        resolution=np.array([step]),
    )


@dataclass(frozen=True, slots=True)
class TorqueSimulator:
    """Satisfies `Simulator`: ``run.u`` is the position, the output is the torque."""

    equations: Equations
    kernel: CompiledKernel

    @classmethod
    def of(cls, joint: Equations) -> TorqueSimulator:
        """Compile the torque equation of a joint."""
        return cls.of_torque(torque_equations(joint))

    @classmethod
    def of_torque(cls, equations: Equations) -> TorqueSimulator:
        """Compile what `torque_equations` returned."""
        return cls(equations, CompiledKernel.of(equations))

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`; there is no observer, ``gain`` must be 0."""
        if gain:
            msg = "the torque equation has no observer: use gains=(0.0,)"
            raise ValueError(msg)
        inputs = measured_motion(run)
        start = np.zeros(len(self.equations.states)) if x0 is None else x0
        if not sensitivities:
            return Trajectory(t=run.t, y=self.kernel.simulate(run.t, inputs, theta, start, linear=True))
        y, dy = self.kernel.simulate_tangent(run.t, inputs, theta, start, linear=True)
        n = len(self.equations.parameters)
        return Trajectory(t=run.t, y=y, dy_dtheta=dy[..., :n], dy_dx0=dy[..., n:])


def measured_motion(run: Run) -> Array:
    """Return position, speed and acceleration that belong to each row's torque from ``run.u``, shape (n_t, 3).

    A torque that holds until the next row belongs to the motion half a step later.
    """
    m = smooth(run.but(y=run.u), width=WIDTH_S)
    t = run.t + 0.5 * np.diff(run.t, append=run.t[-1]) if run.hold == "zero" else run.t
    return np.column_stack([np.interp(t, m.t, signal) for signal in (m.q, m.v, m.a)])
