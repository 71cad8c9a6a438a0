"""A Stribeck curve that follows the speed with a delay."""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, fade_in, parameter, v
from haptid.model.equations.equations import State

T, seen = sp.symbols("friction_lag_time seen_speed", real=True)
LEAST = sp.Float(2e-3)
held = sp.Max(T, LEAST)

EFFECT = Effect(
    id="friction_lag",
    title="friction that follows the speed with a lag",
    formula="Stribeck velocity u with T·u̇ = q̇ − u",
    lives_in="reversal",
    side="friction",
    parameters=(parameter("friction_lag_time", "s", "lag of the Stribeck curve", 0.02, 0.0, 2.0),),
    shapes=(("friction_lag_time", (0.004, 0.02, 0.06, 0.2, 0.6)),),
    rivals=("amplifier_lag", "time_delay"),
    stribeck_velocity=fade_in(T, LEAST, seen, v),
    states=(
        EffectState(
            state=State(id="seen_speed", unit="rad/s", description="speed that the Stribeck curve sees"),
            rhs=(v - seen) / held,
            rate=1 / held,
        ),
    ),
)
