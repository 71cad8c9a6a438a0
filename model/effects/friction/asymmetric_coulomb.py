"""Dry friction that differs between the two directions of motion."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, v

a1 = sp.Symbol("coulomb_asymmetry", real=True)

EFFECT = Effect(
    id="asymmetric_coulomb",
    title="dry friction that differs between directions",
    formula="Fc, Fs times (1 + a·sgn q̇)",
    lives_in="velocity",
    side="friction",
    parameters=(parameter("coulomb_asymmetry", "1", "relative difference of dry friction", 0.02, -0.9, 0.9),),
    rivals=("payload_gravity",),
    coulomb_level=1 + a1 * sp.sign(v),
)
