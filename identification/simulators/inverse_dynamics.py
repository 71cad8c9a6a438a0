"""Inverse dynamics of one joint, for runs recorded under position control: measured motion in, torque out.

The torque of a position controller holds the joint at the controller's reference, so that a simulation from this torque
drifts. The same equation, q̈ = f₀ + f₁·τ, is therefore solved for the torque, with the states of friction law and
effects driven by the measured position and speed:

    τ = (q̈ − f₀)/f₁, which is (M·q̈ + g_c·cos q + g_s·sin q + Ks·(q − epos) + friction)/Kp of a joint without effects.

Effects on the path of the torque, such as a delay, are followed forward from the recorded torque: with w what reaches
the joint of a command τ, and f₁ the acceleration per unit of w, the torque is τ + (q̈ − q̈(τ))/f₁, which is the same
where w = τ. Effects on the path of the reading cannot be inverted.

1. `torque_equations` turns the equation of motion of a joint into the torque equation.
2. `torque_run` exchanges torque and position of a run, both through the same filter: what is linear in the raw signals
   is so in the filtered ones.
3. `TorqueSimulator` evaluates the torque equation along that motion. With G for the filter, the measured torque is
   G·G·τ, and so has to be what is computed. What is linear in the motion, M·q̈ + σ2·q̇ + Ks·q, has passed G with the
   motion; the rest, friction that turns within a row or a wave over position, has not, and passes it here:
   G·(L(G·q) + G·N(G·q)), with L the linear part and N the rest (the parallel filter of Gautier 1997).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from haptid.identification.simulators.protocol import Trajectory
from haptid.measurement.signals.filtered_motion import common_width, filter_run
from haptid.measurement.signals.noise import estimate_noise
from haptid.measurement.signals.resolution import estimate_resolution
from haptid.measurement.signals.smoothing import convolve_gaussian
from haptid.measurement.values.run import Array, Run
from haptid.model.equations.equations import Equations, Input, Output
from haptid.model.friction.registry import law_named
from haptid.model.kernel.cache import cached_kernel
from haptid.model.kernel.compiled import CompiledKernel
from haptid.model.thresholds import THRESHOLDS

SPEED, ACCELERATION, TORQUE = "filtered_speed", "filtered_acceleration", "filtered_torque"
WIDTH, ACCELERATION_NOISE = "filter_width", "acceleration_noise"
"""Columns of a `torque_run`: speed [rad/s], acceleration [rad/s²] and torque [N m] after one pass of the filter, width
of the filter [rows], and what the position's noise leaves in the acceleration [rad/s²]."""


def torque_equations(
    equations: Equations, prompt: Equations | None = None, *, nominal: Equations | None = None
) -> Equations:
    """Solve the equation of motion of one joint for its torque.

    Parameters
    ----------
    equations
        Equations of a single joint, with effects or without; their parameters keep bounds, priors and first guesses.
    prompt
        The same without the effects on the path of the torque, where there are such effects.
    nominal
        The same without any effect, whose linear part is taken of every model that is compared with it: an effect that
        makes the inertia a function of position would else filter the noise of the whole acceleration once more, and
        gain by that alone. ``equations`` where None.

    Returns
    -------
    Equations
        Inputs: position q, speed v, acceleration a, and with ``prompt`` the recorded torque. States: those of friction
        law and effects. Outputs: torque τ [N m], or force [N] of a prismatic joint, and its part that is linear in
        motion and recorded torque.

    Raises
    ------
    ValueError
        Where the equations are not `invertible`.
    """
    if not (invertible(equations) if prompt is None else _has_slope(prompt)):
        msg = f"{equations.name} cannot be read from motion to torque"
        raise ValueError(msg)
    position, speed = equations.states[:2]
    recorded = equations.inputs[:1] if prompt else ()
    a = Input(id="a", unit=f"{position.unit}/s^2", description="measured acceleration")
    if prompt is None:
        torque = needed = needed_torque(equations, a.symbol)
    else:
        _, slope = _acceleration(prompt)
        torque = recorded[0].symbol + (a.symbol - sp.sympify(equations.rhs[1])) / slope
        needed = needed_torque(prompt, a.symbol)
    # What follows the recorded torque is as filtered as that is.
    linear = torque - needed + _linear_part(nominal or prompt or equations, a.symbol)
    sizes = law_named(equations.friction[0]).nominal({x.id: x.initial for x in equations.parameters})
    first_effect = 2 + len(sizes)
    of_friction = zip(equations.states[2:first_effect], sizes, strict=True)
    return replace(
        equations,
        name=f"{equations.name}_torque",
        title=f"{equations.title}, from measured motion to torque",
        joints=(),
        states=(*(replace(s, nominal=max(n, 1e-12)) for s, n in of_friction), *equations.states[first_effect:]),
        inputs=(
            Input(id=position.id, unit=position.unit, description="measured position"),
            Input(id=speed.id, unit=speed.unit, description="measured speed"),
            a,
            *recorded,
        ),
        outputs=(
            Output(
                id="torque",
                unit=equations.inputs[0].unit,
                description="torque that the measured motion needs",
                expression=torque,
            ),
            Output(
                id="linear",
                unit=equations.inputs[0].unit,
                description="its part that is linear in motion and recorded torque",
                expression=linear,
            ),
        ),
        rhs=equations.rhs[2:],
        rates=equations.rates[2:],
    )


def _linear_part(equations: Equations, a: sp.Symbol) -> sp.Expr:
    """Return the terms c·q̈, c·q̇ and c·q of inertia, viscous friction and spring, c free of motion and states.

    Other friction is left whole: its parts that are linear in the speed cancel against others while the joint slides.
    """
    torque = needed_torque(equations, a)
    symbols = {q.id: q.symbol for q in equations.parameters}
    of_terms = (a, symbols.get(law_named(equations.friction[0]).roles.viscous), symbols.get("Ks"))
    motion = (equations.states[0].symbol, equations.states[1].symbol, a)
    states = {state.symbol for state in equations.states[2:]}
    linear = sp.S.Zero
    for symbol in of_terms:
        if symbol is None:
            continue
        for term in sp.Add.make_args(sp.expand(symbol * sp.diff(torque, symbol))):
            of_motion = [x for x in motion if term.has(x)]
            if len(of_motion) == 1 and not (term / of_motion[0]).free_symbols & {*motion, *states}:
                linear += term
    return linear


def invertible(equations: Equations) -> bool:
    """Whether the equations of one joint can be read from motion to torque.

    Parameters
    ----------
    equations
        Equations from torque to position.

    Returns
    -------
    bool
        Whether the output is the position, the acceleration is linear in the torque, and no other state depends on it.
    """
    tau = equations.inputs[0].symbol
    others = (*equations.rhs[2:], *equations.rates[2:])
    return _has_slope(equations) and not any(sp.sympify(e).has(tau) for e in others)


def _has_slope(equations: Equations) -> bool:
    """Whether the output is the position, and the acceleration is linear in the torque."""
    reads_position = equations.outputs[0].expression == equations.states[0].symbol
    # The slope f₁ of an acceleration that is linear in τ is free of τ.
    return bool(reads_position and not _acceleration(equations)[1].has(equations.inputs[0].symbol))


def _acceleration(equations: Equations) -> tuple[sp.Expr, sp.Expr]:
    """Return the acceleration without torque f₀ and the slope f₁ of the acceleration over the torque."""
    tau = equations.inputs[0].symbol
    acceleration = sp.sympify(equations.rhs[1])
    return acceleration.subs(tau, 0), sp.diff(acceleration, tau)


def needed_torque(equations: Equations, acceleration: sp.Symbol) -> sp.Expr:
    """Solve the equation of motion of one joint for the torque that an acceleration needs, (q̈ − f₀)/f₁.

    Parameters
    ----------
    equations
        Equations of a single joint, whose acceleration is linear in the torque.
    acceleration
        Symbol of q̈.

    Returns
    -------
    sympy.Expr
        Torque [N m], or force [N] of a prismatic joint.
    """
    free, slope = _acceleration(equations)
    return (acceleration - free) / slope


def torque_run(run: Run, width: float | None = None, delay: float = 0.0, inertia: float = 0.0) -> Run:
    """Exchange torque and position of a single joint's run, both filtered alike.

    Parameters
    ----------
    run
        Run of one joint.
    width
        Standard deviation of the filter [s]; the one that this run asks for where None.
    delay
        Delay of the recorded torque [s]: τ(t − T) acts at t.
    inertia
        Inertia M of the joint [kg m²], or mass [kg], by which noise of the position becomes one of the torque.

    Returns
    -------
    Run
        On an even grid without the rows at either end that the filter has no full surroundings for: ``u`` is the
        filtered position [rad], ``y`` the torque [N m] after two passes of the filter, ``extra`` holds filtered speed
        and acceleration. The noise is that of the raw torque's neighbouring rows and of the step of its numbers, after
        the two passes, and with M that of the acceleration: √(σ_τ² + (M·σ_a)²), σ_a from the noise of the position.
    """
    m = filter_run(run, width).with_delay(delay)
    rows = slice(m.edge, m.t.size - m.edge)
    resolution = estimate_resolution(run.u[:, 0])
    # Most of a torque that rests is one number: its neighbouring rows show nothing, and the step alone tells its error.
    raw = float(np.hypot(estimate_noise(run.t, run.u[:, 0], resolution), resolution / np.sqrt(12.0)))
    # A sensor's noise that nobody knows yet is NaN.
    of_acceleration = m.acceleration_noise_gain * float(np.nan_to_num(run.sensor_std[0]))
    turned = run.but(
        t=m.t[rows] - m.t[m.edge],
        u=m.q[rows],
        y=m.through_filter(m.torque)[rows],
        v=None,
        noise=np.array([raw * m.white_noise_gain]),
        resolution=np.zeros(1),
        hold="linear",
        score_from=m.interior.start - m.edge,
        start_time=run.start_time + float(m.t[m.edge]),
        extra={
            SPEED: m.v[rows, 0],
            ACCELERATION: m.a[rows, 0],
            TORQUE: m.torque[rows, 0],
            WIDTH: np.full(m.t[rows].size, m.width_in_rows),
            ACCELERATION_NOISE: np.full(m.t[rows].size, of_acceleration),
        },
        drive_inputs={},
    )
    return turned.but(noise=np.array([noise_along(turned, inertia)]))


def noise_along(turned: Run, inertia: float) -> float:
    """Return the noise of a torque along the measured motion, √(σ_τ² + (M·σ_a)²).

    Parameters
    ----------
    turned
        A `torque_run`, whose noise σ_τ is that of its torque alone.
    inertia
        Inertia M of the joint [kg m²], or mass [kg], by which noise of the position becomes one of the torque.

    Returns
    -------
    float
        In N m, or N of a prismatic joint.
    """
    return float(np.hypot(turned.noise[0], inertia * turned.extra[ACCELERATION_NOISE][0]))


def torque_runs(runs: Sequence[Run], delay: float = 0.0, inertia: float = 0.0) -> tuple[Run, ...]:
    """Exchange torque and position of all runs of a joint, with one filter for all (`torque_run`).

    Parameters
    ----------
    runs
        Runs of one joint.
    delay
        Delay of the recorded torque [s].
    inertia
        Inertia of the joint [kg m²], or mass [kg], as `torque_run` takes it.

    Returns
    -------
    tuple of Run
        `torque_run` of each, with the `common_width` of all. One sensor recorded them: no run has less noise than the
        median of all runs. A run at rest for most of its time would weigh as much as its torque is quiet there.
    """
    width = common_width(runs)
    turned = [torque_run(run, width, delay, inertia) for run in runs]
    usual = np.median([run.noise for run in turned], axis=0) if turned else 0.0
    return tuple(run.but(noise=np.maximum(run.noise, usual)) for run in turned)


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
    def of(cls, joint: Equations, *, step: float = THRESHOLDS.inner_step_s) -> TorqueSimulator:
        """Compile the torque equation of a joint.

        Parameters
        ----------
        joint
            Equations of motion of a single joint, with effects or without.
        step
            Inner step [s].

        Returns
        -------
        TorqueSimulator

        Raises
        ------
        ValueError
            Where the equations are not `invertible`.
        NumericalError
            Where the compiler is missing or fails.
        """
        return cls.of_torque(torque_equations(joint), step=step)

    @classmethod
    def of_torque(cls, equations: Equations, *, step: float = THRESHOLDS.inner_step_s) -> TorqueSimulator:
        """Compile a torque equation.

        Parameters
        ----------
        equations
            Torque equation, as `torque_equations` returns it.
        step
            Inner step [s].

        Returns
        -------
        TorqueSimulator

        Raises
        ------
        NumericalError
            Where the compiler is missing or fails.
        """
        return cls(equations, cached_kernel(equations, step=step))

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
        inputs = self.inputs(run)
        start = np.zeros(len(self.equations.states)) if x0 is None else x0
        if not sensitivities:
            return Trajectory(
                t=run.t, y=_as_measured(run, self.kernel.simulate(run.t, inputs, theta, start, linear=True))
            )
        y, dy = self.kernel.simulate_tangent(run.t, inputs, theta, start, linear=True)
        y, dy = _as_measured(run, y), _as_measured(run, dy)
        n = len(self.equations.parameters)
        return Trajectory(t=run.t, y=y, dy_dtheta=dy[..., :n], dy_dx0=dy[..., n:])

    def simulate_many(self, thetas: Array, run: Run, *, x0: Array | None = None) -> Array:
        """Compute the torque of a run for many parameter sets together.

        Parameters
        ----------
        thetas
            Parameters, shape (n_sets, n_p).
        run
            Run of `torque_run`.
        x0
            Initial state, shape (n_x,); 0 where None.

        Returns
        -------
        ndarray, shape (n_sets, n_t, 1)
            Torque [N m] or force [N], filtered as the measured one.
        """
        start = np.zeros(len(self.equations.states)) if x0 is None else x0
        starts = np.broadcast_to(start, (len(thetas), start.size))
        torques = self.kernel.simulate_many(run.t, self.inputs(run), thetas, starts, linear=True)
        return np.moveaxis(_as_measured(run, np.moveaxis(torques, 0, -1)), -1, 0)

    def inputs(self, run: Run) -> Array:
        """Return the inputs of the torque equation along a run.

        Parameters
        ----------
        run
            Run of `torque_run`.

        Returns
        -------
        ndarray, shape (n_t, n_inputs)
            Position [rad], speed [rad/s], acceleration [rad/s²], and the recorded torque [N m] where it is an input.
        """
        motion = measured_motion(run)
        takes_torque = len(self.equations.inputs) > motion.shape[1]
        return np.column_stack([motion, run.extra[TORQUE]]) if takes_torque else motion


def filter_as(run: Run, torque: Array) -> Array:
    """Filter a torque along the motion of a `torque_run` as its measured torque was filtered.

    Parameters
    ----------
    run
        Run of `torque_run`, which holds the width of the filter.
    torque
        Torque [N m] or its derivatives, shape (n_t, …).

    Returns
    -------
    ndarray, shape (n_t, …)
        The same in the same unit, convolved with the run's Gaussian along the rows.
    """
    return convolve_gaussian(torque, float(run.extra[WIDTH][0]))


def _as_measured(run: Run, outputs: Array) -> Array:
    """Filter the outputs of the torque equation, shape (n_t, 2, …), to the torque as measured, shape (n_t, 1, …)."""
    torque, linear = outputs[:, :1], outputs[:, 1:]
    return filter_as(run, linear + filter_as(run, torque - linear))


def measured_motion(run: Run) -> Array:
    """Return the filtered motion that a `torque_run` holds.

    Parameters
    ----------
    run
        Run whose ``u`` is the filtered position [rad].

    Returns
    -------
    ndarray, shape (n_t, 3)
        Position [rad], speed [rad/s] and acceleration [rad/s²].
    """
    return np.column_stack([run.u[:, 0], run.extra[SPEED], run.extra[ACCELERATION]])
