"""A Stribeck curve that falls more slowly or more steeply than a Gaussian."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter

e = sp.Symbol("stribeck_exponent_change", real=True)

EFFECT = Effect(
    id="stribeck_shape",
    title="Stribeck curve of another exponent",
    formula="Fc + (Fs − Fc)·exp(−|q̇/vs|^(2 + e))",
    lives_in="velocity",
    side="friction",
    parameters=(parameter("stribeck_exponent_change", "1", "exponent of the Stribeck curve, less 2", 0.5, -1.7, 8.0),),
    rivals=("quadratic_drag", "friction_lag"),
    stribeck_exponent=2 + e,
)
