"""Inverse dynamics of one joint, for runs recorded under position control: measured motion in, torque out.

The torque of a position controller holds the joint at the controller's reference, so that a simulation from this torque
drifts. The same equation is therefore solved for the torque, with the states of the friction law driven by the
measured speed:

    τ = (M·q̈ + g_c·cos q + g_s·sin q + Ks·(q − epos) + friction)/Kp

1. `torque_equations` turns the equation of motion of a joint into the torque equation.
2. `torque_run` exchanges torque and position of a run, so that the residual is a torque.
3. `measured_motion` smooths the position into position, speed and acceleration.
4. `TorqueSimulator` evaluates the torque equation along that motion.
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
    """Solve the equation of motion of one joint for its torque.

    Parameters
    ----------
    equations
        Equations of a single joint; their parameters keep bounds, priors and first guesses.

    Returns
    -------
    Equations
        Inputs: position q, speed v, acceleration a. States: those of the friction law. Output: torque τ [N m], or
        force [N] of a prismatic joint.
    """
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
    """Exchange torque and position of a single joint's run.

    Parameters
    ----------
    run
        Run of one joint.

    Returns
    -------
    Run
        ``u`` is the position [rad], ``y`` the torque [N m]; noise and resolution are estimated from the torque, and
        measured velocities are left out.
    """
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
    """Simulator of a joint's torque along its measured motion; satisfies `Simulator`.

    Parameters
    ----------
    equations
        Torque equation, as `torque_equations` returns it.
    kernel
        The compiled equation.

    Notes
    -----
    Runs are those of `torque_run`: ``run.u`` is the position, the output is the torque.
    """

    equations: Equations
    kernel: CompiledKernel

    @classmethod
    def of(cls, joint: Equations) -> TorqueSimulator:
        """Compile the torque equation of a joint.

        Parameters
        ----------
        joint
            Equations of motion of a single joint.

        Returns
        -------
        TorqueSimulator
        """
        return cls.of_torque(torque_equations(joint))

    @classmethod
    def of_torque(cls, equations: Equations) -> TorqueSimulator:
        """Compile a torque equation that `torque_equations` returned."""
        return cls(equations, CompiledKernel.of(equations))

    def simulate(
        self, theta: Array, run: Run, *, x0: Array | None = None, gain: float = 0.0, sensitivities: bool = False
    ) -> Trajectory:
        """See `identification.simulators.protocol.Simulator`.

        Raises
        ------
        ValueError
            For a gain other than 0: the torque equation has no observer.
        """
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
    """Smooth the position of a `torque_run` and differentiate it at the times that the torques belong to.

    Parameters
    ----------
    run
        Run whose ``u`` is the measured position [rad].

    Returns
    -------
    ndarray, shape (n_t, 3)
        Position [rad], speed [rad/s] and acceleration [rad/s²].
    """
    m = smooth(run.but(y=run.u), width=WIDTH_S)
    # A torque that holds until the next row belongs to the motion half a step after its row.
    t = run.t + 0.5 * np.diff(run.t, append=run.t[-1]) if run.hold == "zero" else run.t
    return np.column_stack([np.interp(t, m.t, signal) for signal in (m.q, m.v, m.a)])
