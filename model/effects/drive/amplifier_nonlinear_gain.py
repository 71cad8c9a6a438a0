"""An amplifier whose gain changes with the torque asked for."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, reference, w
from haptid.model.effects.parts.compression import compression
from haptid.model.effects.scales import TORQUE

a1, w0 = sp.symbols("gain_curvature gain_reference", real=True)
CHANGE = a1 * (w / w0) ** 2
PARAMETERS = (
    parameter("gain_curvature", "1", "relative gain at the largest torque", 0.02, -0.6, 3.0),
    reference("gain_reference", "N m", "largest torque τ₀"),
)
RELATIVE = {"gain_reference": TORQUE}
PLACE = 3

EFFECT = Effect(
    id="amplifier_nonlinear_gain",
    title="amplifier gain that changes with torque",
    formula="w = τ·(1 + a·(τ/τ₀)²)",
    lives_in="torque",
    place=PLACE,
    side="input",
    parameters=PARAMETERS,
    relative=RELATIVE,
    rivals=("amplifier_saturation", "cubic_spring"),
    contenders=(compression(CHANGE, "a·(τ/τ₀)²", PARAMETERS, RELATIVE, PLACE),),
    input=w * (1 + CHANGE),
)
