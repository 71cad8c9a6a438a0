"""Errors between the lines of an encoder."""

from haptid.model.effects.effect import Effect, parameter, y
from haptid.model.effects.parts.waves import FINE, size, wave, wave_number
from haptid.model.effects.scales import POSITION

EFFECT = Effect(
    id="encoder_ripple",
    title="fine encoder error at fixed positions",
    formula="y = q + e_s·sin(n·q) + e_c·cos(n·q), n > 20",
    lives_in="position",
    place=10,
    side="output",
    parameters=(
        parameter("encoder_ripple_sin", "rad", "sine part", 0.001, -0.1, 0.1),
        parameter("encoder_ripple_cos", "rad", "cosine part", 0.001, -0.1, 0.1),
        wave_number("encoder_ripple_number", FINE),
    ),
    amplitudes=2,
    relative={"encoder_ripple_sin": POSITION, "encoder_ripple_cos": POSITION, "encoder_ripple_number": 1 / POSITION},
    shapes=(("encoder_ripple_number", FINE),),
    derived=size("encoder_ripple", "rad"),
    rivals=("cogging",),
    output=y + wave("encoder_ripple", y),
)
