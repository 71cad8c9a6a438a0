"""Torque that the motor's magnets add at fixed positions."""

from haptid.model.effects.effect import Effect, parameter
from haptid.model.effects.parts.waves import COARSE, size, wave, wave_number
from haptid.model.effects.scales import POSITION, TORQUE

EFFECT = Effect(
    id="cogging",
    title="cogging torque at fixed positions",
    formula="−a_s·sin(n·q) − a_c·cos(n·q)",
    lives_in="position",
    side="torque",
    parameters=(
        parameter("cogging_sin", "N m", "cogging torque, sine part", 0.01, -1.0, 1.0),
        parameter("cogging_cos", "N m", "cogging torque, cosine part", 0.01, -1.0, 1.0),
        wave_number("cogging_number", COARSE),
    ),
    amplitudes=2,
    relative={"cogging_sin": TORQUE, "cogging_cos": TORQUE, "cogging_number": 1 / POSITION},
    shapes=(("cogging_number", COARSE),),
    derived=size("cogging", "N m"),
    rivals=("position_dependent_friction", "torque_ripple"),
    torque=-wave("cogging"),
)
