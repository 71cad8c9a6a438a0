"""Viscous friction that grows away from q = 0."""

import sympy as sp

from haptid.model.effects.effect import Effect, parameter, q, v
from haptid.model.effects.scales import POSITION, SPEED, TORQUE

d = sp.Symbol("viscous_curvature", real=True)

EFFECT = Effect(
    id="position_dependent_viscous",
    title="viscous friction that changes with position",
    formula="−d·q²·q̇",
    lives_in="position",
    side="torque",
    parameters=(parameter("viscous_curvature", "N m s/rad^3", "growth of viscous friction", 0.02, -3.0, 5.0),),
    relative={"viscous_curvature": TORQUE / (SPEED * POSITION**2)},
    rivals=("position_dependent_friction", "quadratic_drag"),
    torque=-d * q**2 * v,
)
