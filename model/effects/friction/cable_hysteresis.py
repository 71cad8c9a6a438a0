"""A second, slower bristle: cables and tubes that drag and then slip (Maxwell slip)."""

import sympy as sp

from haptid.model.effects.effect import Effect, EffectState, parameter, v
from haptid.model.effects.scales import POSITION, TORQUE
from haptid.model.equations.equations import State

k, delta, s = sp.symbols("hysteresis_stiffness hysteresis_travel cable_stretch", real=True)
rate = sp.Abs(v) / delta

EFFECT = Effect(
    id="cable_hysteresis",
    title="cable that drags along before it slips",
    formula="−k·s, ṡ = q̇ − |q̇|·s/δ",
    lives_in="reversal",
    side="torque",
    parameters=(
        parameter("hysteresis_stiffness", "N m/rad", "stiffness before slip", 0.05, 0.0, 20.0),
        parameter("hysteresis_travel", "rad", "travel after which it slips", 0.2, 0.005, 3.0, scale="log"),
    ),
    relative={"hysteresis_stiffness": TORQUE / POSITION, "hysteresis_travel": POSITION},
    shapes=(("hysteresis_travel", (0.03, 0.1, 0.3, 0.8, 2.0)),),
    rivals=("cubic_spring",),
    torque=-k * s,
    states=(
        EffectState(
            state=State(id="cable_stretch", unit="rad", description="stretch of the dragging cable"),
            rhs=v - rate * s,
            rate=rate,
        ),
    ),
)
