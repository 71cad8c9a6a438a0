"""An amplifier that cannot give more than its largest torque: gradually, or at once."""

from functools import partial

import sympy as sp

from haptid.model.effects.effect import Effect, fade_in, parameter, reference, w
from haptid.model.effects.parts.compression import compression
from haptid.model.effects.scales import TORQUE

kappa, least = sp.symbols("saturation_softness saturation_least", real=True)
cut, top = sp.symbols("saturation_cut saturation_reference", real=True)
_limit = top * (1 - cut)
PLACE = 4
SOFT = (
    parameter("saturation_softness", "1/(N m)", "1/τ_max", 0.3, 0.0, 5.0),
    reference("saturation_least", "1/(N m)", "softness below which the effect fades linearly"),
)
RELATIVE = {"saturation_softness": 1 / TORQUE, "saturation_least": sp.Float(0.1) / TORQUE}
_effect = partial(
    Effect,
    id="amplifier_saturation",
    lives_in="torque",
    place=PLACE,
    side="input",
    rivals=("amplifier_nonlinear_gain", "end_stop", "cubic_spring"),
)

EFFECTS = (
    _effect(
        variant="soft",
        title="amplifier that saturates gradually",
        formula="w = τ_max·tanh(τ/τ_max)",
        parameters=SOFT,
        relative=RELATIVE,
        derived=(("saturation_torque", "N m", 1 / kappa),),
        contenders=(compression(-((kappa * w) ** 2) / 3, "−(τ/τ_max)²/3", SOFT, RELATIVE, PLACE),),
        input=fade_in(kappa, least, sp.tanh(kappa * w) / kappa, w),
    ),
    _effect(
        variant="hard",
        title="amplifier that clips",
        formula="w = τ clipped to ±τ_max, τ_max = (1 − c)·τ₀",
        parameters=(
            parameter("saturation_cut", "1", "share of the largest torque that is cut off", 0.05, 0.0, 0.95),
            reference("saturation_reference", "N m", "largest torque τ₀"),
        ),
        relative={"saturation_reference": TORQUE},
        shapes=(("saturation_cut", (0.01, 0.05, 0.15, 0.3)),),
        derived=(("saturation_torque", "N m", _limit),),
        input=sp.Max(sp.Min(w, _limit), -_limit),
    ),
)
