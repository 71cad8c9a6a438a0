"""Viscous friction that differs between the two directions of motion."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, v

a1 = sp.Symbol("viscous_asymmetry", real=True)

EFFECT = Effect(
    id="asymmetric_viscous",
    title="viscous friction that differs between directions",
    formula="σ2 times (1 + a·sgn q̇)",
    lives_in="velocity",
    side="friction",
    parameters=(parameter("viscous_asymmetry", "1", "relative difference of viscous friction", 0.02, -0.95, 0.95),),
    rivals=("asymmetric_coulomb",),
    viscous_level=1 + a1 * sp.sign(v),
)
