"""A motor whose torque constant changes with position."""

from haptid.model.effects.effect import Effect, parameter, w
from haptid.model.effects.parts.waves import COARSE, size, wave, wave_number
from haptid.model.effects.scales import POSITION

EFFECT = Effect(
    id="torque_ripple",
    title="torque constant that changes with position",
    formula="w = τ·(1 + a_s·sin(n·q) + a_c·cos(n·q))",
    lives_in="position",
    place=6,
    side="input",
    parameters=(
        parameter("ripple_sin", "1", "relative ripple, sine part", 0.01, -0.7, 0.7),
        parameter("ripple_cos", "1", "relative ripple, cosine part", 0.01, -0.7, 0.7),
        wave_number("ripple_number", COARSE),
    ),
    amplitudes=2,
    relative={"ripple_number": 1 / POSITION},
    shapes=(("ripple_number", COARSE),),
    derived=size("ripple", "1"),
    rivals=("cogging",),
    input=w * (1 + wave("ripple")),
)
