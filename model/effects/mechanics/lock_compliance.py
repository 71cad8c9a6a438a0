"""A second inertia behind an elastic element: a mode that this joint's acceleration drives.

A locked neighbour that gives way moves so. So does the link behind an elastic transmission whose motor is measured:
μ is then its share of the whole inertia. `tendon_elasticity` is a transmission whose link is measured.

The second inertia may rub on its own, as a carriage on its rail behind a belt does. Friction there acts on the motor
through the elastic element only, and the joint's own friction cannot stand for it near the resonance.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, a, parameter, reference, v
from haptid.model.effects.scales import INERTIA, SPEED, TORQUE
from haptid.model.equations.equations import State

mu, omega, zeta = sp.symbols("lock_share lock_frequency lock_damping", real=True)
eta, rate = sp.symbols("neighbour neighbour_speed", real=True)
gamma, delta, turn = sp.symbols("lock_deceleration lock_decay lock_reversal", real=True)
_restoring = 2 * zeta * omega * rate + omega**2 * eta
_second_speed = v + rate
_slope_of_sign = (1 - sp.tanh(_second_speed / turn) ** 2) / turn

_PARAMETERS = (
    parameter("lock_share", "1", "share μ of the inertia behind the elastic element", 0.02, 0.0, 0.9),
    parameter("lock_frequency", "1/s", "angular frequency Ω of the mode", 15.0, 1.0, 300.0, scale="log"),
    parameter("lock_damping", "1", "damping ratio ζ of the mode", 0.1, 0.005, 3.0, scale="log"),
)
_FREQUENCIES = ("lock_frequency", (2.0, 3.5, 6.0, 10.0, 17.0, 30.0, 60.0))


def _states(friction: sp.Expr, slope: sp.Expr) -> tuple[EffectState, ...]:
    """Write the deflection of the elastic element, where friction over the second inertia has a value and a slope."""
    return (
        EffectState(state=State(id="neighbour", unit="rad", description="deflection of the elastic element"), rhs=rate),
        EffectState(
            state=State(id="neighbour_speed", unit="rad/s", description="speed of that deflection"),
            rhs=-a - _restoring - friction,
            rate=2 * zeta * omega + slope,
        ),
    )


EFFECTS = (
    Effect(
        id="lock_compliance",
        # A device of one joint has no neighbour: the elastic transmission, which any joint may have, comes first.
        title="second inertia behind an elastic element: an elastic transmission, as a cable, belt or harmonic drive, "
        "where the position is measured at the motor, or a locked neighbour that gives way",
        formula="η̈ + 2ζΩ·η̇ + Ω²·η = −q̈, the joint feels −μ·M·η̈",
        lives_in="frequency",
        side="torque",
        parameters=_PARAMETERS,
        shapes=(("lock_share", (0.02, 0.15)), _FREQUENCIES, ("lock_damping", (0.03, 0.2))),
        rivals=("tendon_elasticity",),
        acceleration=(a + mu * _restoring) / (1 - mu),
        states=_states(sp.S.Zero, sp.S.Zero),
    ),
    Effect(
        id="lock_compliance",
        variant="friction",
        title="second inertia with friction of its own behind an elastic element: an elastic transmission, as a cable, "
        "belt or harmonic drive, where the position is measured at the motor and the load rubs",
        formula="η̈ + 2ζΩ·η̇ + Ω²·η = −q̈ − γ·tanh(ẋ/v₀) − δ·ẋ with ẋ = q̇ + η̇, the joint feels μ·M·(2ζΩ·η̇ + Ω²·η)",
        lives_in="frequency",
        side="torque",
        parameters=(
            *_PARAMETERS,
            parameter("lock_deceleration", "rad/s^2", "its Coulomb friction over the inertia", 0.01, 0.0, 2.0),
            parameter("lock_decay", "1/s", "its viscous friction over the inertia", 0.1, 0.0, 100.0),
            reference("lock_reversal", "rad/s", "speed over which its dry friction turns its sign"),
        ),
        relative={"lock_deceleration": TORQUE / INERTIA, "lock_reversal": sp.Float(0.01) * SPEED},
        shapes=(("lock_share", (0.3,)), _FREQUENCIES, ("lock_damping", (0.03,))),
        rivals=("tendon_elasticity",),
        acceleration=(a + mu * _restoring) / (1 - mu),
        states=_states(gamma * sp.tanh(_second_speed / turn) + delta * _second_speed, gamma * _slope_of_sign + delta),
        resonant_only=True,
    ),
)
