"""An encoder disc that is mounted off its centre."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, y

s, c = sp.symbols("eccentricity_sin eccentricity_cos", real=True)

EFFECT = Effect(
    id="encoder_eccentricity",
    title="encoder mounted off centre",
    formula="y = q + e_s·sin(q) + e_c·cos(q)",
    lives_in="position",
    place=11,
    side="output",
    parameters=(
        parameter("eccentricity_sin", "rad", "sine part", 0.005, -0.3, 0.3),
        parameter("eccentricity_cos", "rad", "cosine part", 0.005, -0.3, 0.3),
    ),
    amplitudes=2,
    derived=(("eccentricity_amplitude", "rad", sp.sqrt(s**2 + c**2)),),
    rivals=("asymmetric_spring", "cubic_spring"),
    output=y + s * sp.sin(y) + c * sp.cos(y),
)
