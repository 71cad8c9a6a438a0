"""A tendon that stretches between rotor and link."""

from haptid.model.effects.effect import Effect
from haptid.model.effects.parts import tendons

NAME = "tendon"
_acceleration, _states = tendons.two_masses(NAME)

EFFECT = Effect(
    id="tendon_elasticity",
    title="tendon that stretches between motor and joint",
    formula="ρM·q̈_m = w − (s + T_d·ṡ)/e, (1 − ρ)M·q̈ = (s + T_d·ṡ)/e − load, s = q_m − q",
    lives_in="frequency",
    side="input",
    parameters=tendons.table(NAME, (0.01, 0.0, 2.0)),
    relative=tendons.relative(NAME),
    shapes=(
        ("tendon_compliance", (0.003, 0.02, 0.1, 0.4)),
        ("tendon_rotor_share", (0.15, 0.4)),
        ("tendon_damping_time", (0.005,)),
    ),
    derived=tendons.derive_stiffness(NAME),
    rivals=("lock_compliance", "time_delay", "amplifier_lag"),
    acceleration=_acceleration,
    states=_states,
)
