"""A second inertia behind an elastic element: a mode that this joint's acceleration drives.

A locked neighbour that gives way moves so. So does the link behind an elastic transmission whose motor is measured:
μ is then its share of the whole inertia. `tendon_elasticity` is a transmission whose link is measured.
"""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, a, parameter
from haptid.model.equations.equations import State

mu, omega, zeta = sp.symbols("lock_share lock_frequency lock_damping", real=True)
eta, rate = sp.symbols("neighbour neighbour_speed", real=True)
_restoring = 2 * zeta * omega * rate + omega**2 * eta

EFFECT = Effect(
    id="lock_compliance",
    # A device of one joint has no neighbour: the elastic transmission, which any joint may have, comes first.
    title="second inertia behind an elastic element: an elastic transmission, as a cable, belt or harmonic drive, "
    "where the position is measured at the motor, or a locked neighbour that gives way",
    formula="η̈ + 2ζΩ·η̇ + Ω²·η = −q̈, the joint feels −μ·M·η̈",
    lives_in="frequency",
    side="torque",
    parameters=(
        parameter("lock_share", "1", "share μ of the inertia behind the elastic element", 0.02, 0.0, 0.9),
        parameter("lock_frequency", "1/s", "angular frequency Ω of the mode", 15.0, 1.0, 300.0, scale="log"),
        parameter("lock_damping", "1", "damping ratio ζ of the mode", 0.1, 0.005, 3.0, scale="log"),
    ),
    shapes=(
        ("lock_share", (0.02, 0.15)),
        ("lock_frequency", (2.0, 3.5, 6.0, 10.0, 17.0, 30.0, 60.0)),
        ("lock_damping", (0.03, 0.2)),
    ),
    rivals=("tendon_elasticity",),
    acceleration=(a + mu * _restoring) / (1 - mu),
    states=(
        EffectState(state=State(id="neighbour", unit="rad", description="deflection of the elastic element"), rhs=rate),
        EffectState(
            state=State(id="neighbour_speed", unit="rad/s", description="speed of that deflection"),
            rhs=-a - _restoring,
            rate=2 * zeta * omega,
        ),
    ),
)
