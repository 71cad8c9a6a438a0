"""Torque that the motor's magnets, or the teeth of its gear, add at fixed positions: one wave, or its harmonics too.

Teeth and magnets make waves of different length, so that a second wave may stand beside the first.
"""

from functools import partial

from haptid.model.effects.effect import Effect, parameter
from haptid.model.effects.parts.waves import COARSE, WHOLE, series, series_amplitudes, size, wave, wave_number
from haptid.model.effects.scales import POSITION, TORQUE

HARMONICS = 3
TITLE = "cogging torque at fixed positions"
FAMILY = series_amplitudes("cogging", "N m", "cogging torque", 0.01, 1.0, HARMONICS)
_effect = partial(
    Effect,
    id="cogging",
    lives_in="position",
    side="torque",
    rivals=("position_dependent_friction", "torque_ripple"),
)

EFFECTS = (
    _effect(
        title=TITLE,
        formula="−a_s·sin(n·q) − a_c·cos(n·q)",
        parameters=(
            parameter("cogging_sin", "N m", "cogging torque, sine part", 0.01, -1.0, 1.0),
            parameter("cogging_cos", "N m", "cogging torque, cosine part", 0.01, -1.0, 1.0),
            wave_number("cogging_number", COARSE),
        ),
        amplitudes=2,
        shapes=(("cogging_number", COARSE),),
        relative={"cogging_sin": TORQUE, "cogging_cos": TORQUE, "cogging_number": 1 / POSITION},
        derived=size("cogging", "N m"),
        torque=-wave("cogging"),
    ),
    _effect(
        variant="harmonics",
        title=TITLE,
        formula="−Σ a_s,h·sin(h·n·q) + a_c,h·cos(h·n·q), h = 1 … 3",
        parameters=(*FAMILY, wave_number("cogging_number", WHOLE)),
        amplitudes=len(FAMILY),
        shapes=(("cogging_number", WHOLE),),
        relative={x.id: TORQUE for x in FAMILY} | {"cogging_number": 1 / POSITION},
        torque=-series("cogging", HARMONICS),
        series_of="cogging",
    ),
    _effect(
        variant="second",
        title="second cogging torque at fixed positions",
        formula="−b_s·sin(m·q) − b_c·cos(m·q)",
        parameters=(
            parameter("second_cogging_sin", "N m", "second cogging torque, sine part", 0.01, -1.0, 1.0),
            parameter("second_cogging_cos", "N m", "second cogging torque, cosine part", 0.01, -1.0, 1.0),
            wave_number("second_cogging_number", WHOLE),
        ),
        amplitudes=2,
        shapes=(("second_cogging_number", WHOLE),),
        relative={"second_cogging_sin": TORQUE, "second_cogging_cos": TORQUE, "second_cogging_number": 1 / POSITION},
        derived=size("second_cogging", "N m"),
        torque=-wave("second_cogging"),
        torque_only=True,
        again=True,
    ),
)
